"""Bringing a database to the schema of this version, and back."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext

from station.store.engine import open_engine

NEWEST = "head"
EMPTY = "base"
_SCRIPTS = Path(__file__).with_name("migrations")


def migrate(url: str, revision: str = NEWEST) -> None:
    """Bring the database to a revision: `NEWEST`, `EMPTY` or one by name."""
    present = revision_of(url)
    engine = open_engine(url)
    try:
        with engine.begin() as connection:
            config = Config()
            config.set_main_option("script_location", str(_SCRIPTS).replace("%", "%%"))
            config.attributes["connection"] = connection
            if revision == EMPTY or (present is not None and present > revision != NEWEST):
                command.downgrade(config, revision)
            else:
                command.upgrade(config, revision)
    finally:
        engine.dispose()


def revision_of(url: str) -> str | None:
    """Return the revision a database is at; None for an empty one."""
    engine = open_engine(url)
    try:
        with engine.connect() as connection:
            return MigrationContext.configure(connection).get_current_revision()
    finally:
        engine.dispose()
