"""Bringing a database to the schema of this version, and back."""

from pathlib import Path
from typing import Any

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, event

from station.errors import StationError, StoreNewer
from station.store.connecting import open_engine
from station.store.integrity import file_of

NEWEST = "head"
EMPTY = "base"
_SCRIPTS = Path(__file__).with_name("migrations")


def migrate(url: str, revision: str = NEWEST, *, losing: bool = False) -> None:
    """Bring the database to a revision: `NEWEST`, `EMPTY` or one by name.

    Parameters
    ----------
    losing
        Whether an audit trail may be dropped on the way to a revision that has none.

    Raises
    ------
    StoreNewer
        If the database is of a newer version of the station; nothing is changed then.
    StationError
        If rows would be left that refer to none, or an audit trail would be lost; likewise.
    """
    present = revision_of(url)
    ensure_known(present)
    engine = open_engine(url)
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _let_tables_be_replaced)
    try:
        with engine.begin() as connection:
            config = _config()
            config.attributes["connection"] = connection
            config.attributes["losing"] = losing
            if revision == EMPTY or (present is not None and present > revision != NEWEST):
                command.downgrade(config, revision)
            else:
                command.upgrade(config, revision)
            _ensure_references_hold(connection)
    finally:
        engine.dispose()


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", str(_SCRIPTS).replace("%", "%%"))
    return config


def ensure_known(revision: str | None) -> None:
    """Refuse a database that a newer version of the station has made.

    Raises
    ------
    StoreNewer
        If this version has no step that leads to its revision.
    """
    steps = ScriptDirectory.from_config(_config())
    known = {step.revision for step in steps.walk_revisions()}
    if revision is not None and revision not in known:
        raise StoreNewer(
            f"the store is at revision {revision}, this version knows up to {max(known)}; "
            "install the version that made it, or restore an older backup"
        )


def _let_tables_be_replaced(connection: Any, _record: Any) -> None:
    # SQLite alters a table by dropping it for a new one, which rows that refer to it forbid; it
    # takes the setting outside of a transaction alone.
    connection.execute("PRAGMA foreign_keys = OFF")


def _ensure_references_hold(connection: Connection) -> None:
    if connection.dialect.name != "sqlite":
        return
    dangling = connection.exec_driver_sql("PRAGMA foreign_key_check").first()
    if dangling is not None:
        table, row, parent, _ = dangling
        raise StationError(
            f"the migration would leave row {row} of {table} without its {parent}; "
            "nothing was changed: keep the database and report this"
        )


def revision_of(url: str) -> str | None:
    """Return the revision a database is at; None for an empty one, or a file that is not there."""
    file = file_of(url)
    if file is not None and not file.exists():
        return None  # looking would make it
    engine = open_engine(url)
    try:
        with engine.connect() as connection:
            return MigrationContext.configure(connection).get_current_revision()
    finally:
        engine.dispose()
