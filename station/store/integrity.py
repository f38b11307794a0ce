"""Whether a database can be relied on: asked before the station writes to it."""

from pathlib import Path

from sqlalchemy import Connection, text
from sqlalchemy.exc import DBAPIError

from station.errors import StoreUnusable
from station.store.connecting import database_url, looking, open_engine

_OLDEST_POSTGRESQL = 130_000
_LARGE_BYTES = 2 * 10**9
_LARGE_TABLES = frozenset({"measurements", "measurement_profiles", "calibration_points"})
_CURE = "stop the station and bring back the last backup: station restore FILE"


def ensure_sound(url: str) -> None:
    """Let the station start only on a database that answers and is whole.

    A file of SQLite is read through and its structure checked; of one beyond 2 GB not the tables
    that make it so large, as a station that starts again must not take minutes.  PostgreSQL checks
    itself; asked is whether it answers, and whether it is one that the station works with.

    Raises
    ------
    StoreUnusable
        If it does not answer, is damaged, or is none.
    """
    file = file_of(url)
    if file is not None and not file.exists():
        return  # made by the first migration
    engine = open_engine(url)
    try:
        with looking(engine).connect() as connection:
            if file is None:
                _ensure_supported(connection)
            else:
                large = file.stat().st_size > _LARGE_BYTES
                _ensure_whole(connection, file, _LARGE_TABLES if large else frozenset())
    except DBAPIError as error:
        raise StoreUnusable(_said(error, file)) from error
    finally:
        engine.dispose()


def file_of(url: str) -> Path | None:
    """Return the file of a store in SQLite; None of one in PostgreSQL."""
    parsed = database_url(url)
    on_sqlite = parsed.get_backend_name() == "sqlite"
    return Path(parsed.database) if on_sqlite and parsed.database else None


def _said(error: DBAPIError, file: Path | None) -> str:
    why = " ".join(str(error.orig).split())
    if file is None:
        return f"the store does not answer ({why}); start PostgreSQL, or correct store_url"
    return f"{file}: damaged or no store ({why}); {_CURE}"


def _ensure_whole(connection: Connection, file: Path, but: frozenset[str]) -> None:
    names = connection.execute(
        text("SELECT name FROM sqlite_schema WHERE type = 'table'")
    ).scalars()
    for name in sorted(set(names) - but):
        found = connection.exec_driver_sql(f"PRAGMA quick_check('{name}')").scalar()
        if found != "ok":
            raise StoreUnusable(f"{file}: damaged ({' '.join(str(found).split())}); {_CURE}")


def _ensure_supported(connection: Connection) -> None:
    version = int(connection.execute(text("SHOW server_version_num")).scalar_one())
    encoding = connection.execute(text("SHOW server_encoding")).scalar_one()
    if version < _OLDEST_POSTGRESQL or encoding != "UTF8":
        raise StoreUnusable(
            f"PostgreSQL {version // 10_000} with encoding {encoding}; "
            f"allowed: {_OLDEST_POSTGRESQL // 10_000} or newer with UTF8"
        )
