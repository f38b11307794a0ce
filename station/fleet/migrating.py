"""Bringing the fleet's database to the schema of this version."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy.exc import DBAPIError

from station.errors import StationError, StoreUnusable
from station.fleet.connecting import fleet_engine

VERSION_TABLE = "fleet_alembic_version"
EMPTY = "base"
_SCRIPTS = Path(__file__).with_name("migrations")


def migrate_fleet(url: str, revision: str = "head") -> None:
    """Bring the fleet's database to a revision: the newest, `EMPTY`, or one by name.

    Raises
    ------
    StationError
        If the database is of a newer version of the station.
    StoreUnusable
        If it does not answer.
    """
    ensure_not_newer(fleet_revision(url))
    engine = fleet_engine(url)
    try:
        with engine.begin() as connection:
            config = _config()
            config.attributes["connection"] = connection
            if revision == EMPTY:
                command.downgrade(config, revision)
            else:
                command.upgrade(config, revision)
    except DBAPIError as error:
        raise _unusable(error) from error
    finally:
        engine.dispose()


def fleet_revision(url: str) -> str | None:
    """Return the revision the fleet's database is at; None where it has no tables yet.

    Raises
    ------
    StoreUnusable
        If it does not answer.
    """
    engine = fleet_engine(url)
    try:
        with engine.connect() as connection:
            options = {"version_table": VERSION_TABLE}
            return MigrationContext.configure(connection, opts=options).get_current_revision()
    except DBAPIError as error:
        raise _unusable(error) from error
    finally:
        engine.dispose()


def ensure_ready(url: str) -> None:
    """Refuse a fleet's database that is not of this version's schema.

    A station never changes the schema itself: stations of several versions share it.

    Raises
    ------
    StationError
        If `station fleet init` was not run, or another version of it.
    StoreUnusable
        If it does not answer.
    """
    revision = fleet_revision(url)
    ensure_not_newer(revision)
    newest = ScriptDirectory.from_config(_config()).get_current_head()
    if revision != newest:
        raise StationError(
            f"the fleet's database is at revision {revision}, this version writes {newest}; "
            "run `station fleet init` with this version"
        )


def ensure_not_newer(revision: str | None) -> None:
    """Refuse a database that a newer version has made.

    Raises
    ------
    StationError
        If this version has no step that leads to its revision.
    """
    known = {step.revision for step in ScriptDirectory.from_config(_config()).walk_revisions()}
    if revision is not None and revision not in known:
        raise StationError(
            f"the fleet's database is at revision {revision}, this version knows up to "
            f"{max(known)}; bring this station to the version that made it"
        )


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", str(_SCRIPTS).replace("%", "%%"))
    return config


def _unusable(error: DBAPIError) -> StoreUnusable:
    why = " ".join(str(error.orig).split())
    return StoreUnusable(f"the fleet's database cannot be used now ({why})")
