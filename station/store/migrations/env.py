"""What Alembic runs for every migration: inside the transaction that the caller opened."""

from alembic import context

from station.store.tables import Table

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Table.metadata,
    render_as_batch=True,  # SQLite alters a table only by making it anew
)
context.run_migrations()
