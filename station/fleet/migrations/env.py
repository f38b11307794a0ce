"""What Alembic runs for every migration of the fleet's database."""

from alembic import context

from station.fleet.migrating import VERSION_TABLE
from station.fleet.tables import FleetTable

# Alembic fills its `context` while it migrates; whoever else imports this file finds it empty.
if hasattr(context, "config"):
    context.configure(
        connection=context.config.attributes["connection"],
        target_metadata=FleetTable.metadata,
        version_table=VERSION_TABLE,
        render_as_batch=True,  # SQLite alters a table only by making it anew
    )
    context.run_migrations()
