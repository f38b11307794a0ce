"""What Alembic runs for every migration: inside the transaction that the caller opened."""

from alembic import context

from station.store.tables import Table

# Alembic fills its `context` while it migrates; whoever else imports this file finds it empty.
if hasattr(context, "config"):
    context.configure(
        connection=context.config.attributes["connection"],
        target_metadata=Table.metadata,
        render_as_batch=True,  # SQLite alters a table only by making it anew
    )
    context.run_migrations()
