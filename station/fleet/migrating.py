"""Bringing the fleet's database to the schema of this version."""

from pathlib import Path

from sqlalchemy import inspect, text
from sqlalchemy.exc import DBAPIError

from station.errors import StationError
from station.fleet.connecting import fleet_engine, is_there, unusable
from station.fleet.patience import Stop

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
    # Imported here: the process that sends never migrates, and is to stay small.
    from alembic import command  # noqa: PLC0415  see the line above
    from alembic.config import Config  # noqa: PLC0415  as above

    ensure_not_newer(fleet_revision(url))
    engine = fleet_engine(url)
    try:
        with engine.begin() as connection:
            config = Config()
            config.set_main_option("script_location", str(_SCRIPTS).replace("%", "%%"))
            config.attributes["connection"] = connection
            if revision == EMPTY:
                command.downgrade(config, revision)
            else:
                command.upgrade(config, revision)
    except DBAPIError as error:
        raise unusable(error) from error
    finally:
        engine.dispose()


def fleet_revision(url: str, *, stop: Stop | None = None) -> str | None:
    """Return the revision the fleet's database is at; None where it has no tables yet.

    Raises
    ------
    StoreUnusable
        If it does not answer, or `stop` was said meanwhile.
    """
    if not is_there(url):
        return None
    engine = fleet_engine(url, stop=stop)
    try:
        with engine.connect() as connection:
            if not inspect(connection).has_table(VERSION_TABLE):
                return None
            query = text(f"SELECT version_num FROM {VERSION_TABLE}")
            found: str | None = connection.scalar(query)
            return found
    except DBAPIError as error:
        raise unusable(error) from error
    finally:
        engine.dispose()


def ensure_ready(url: str, *, stop: Stop | None = None) -> None:
    """Refuse a fleet's database that is not of this version's schema.

    A station never changes the schema itself: stations of several versions share it.

    Raises
    ------
    StationError
        If `station fleet init` was not run, or another version of it.
    StoreUnusable
        If it does not answer, or `stop` was said meanwhile.
    """
    revision = fleet_revision(url, stop=stop)
    ensure_not_newer(revision)
    newest = known_revisions()[-1]
    if revision is None:
        raise StationError("the fleet's database has no tables yet; run `station fleet init`")
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
    known = known_revisions()
    if revision is not None and revision not in known:
        raise StationError(
            f"the fleet's database is at revision {revision}, this version knows up to "
            f"{known[-1]}; bring this station to the version that made it"
        )


def known_revisions() -> list[str]:
    """Return the revisions this version knows, the oldest first: by the names of their files."""
    steps = (_SCRIPTS / "versions").glob("f[0-9]*_*.py")
    return sorted(path.name.partition("_")[0] for path in steps)
