"""The connection to the database and the two ways to use it: to change, and to look."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from sqlalchemy import Connection, Engine, create_engine, event, text
from sqlalchemy.orm import Session, sessionmaker

_BUSY_TIMEOUT_MS = 10_000
_LOOKING = "station_looking"


def sqlite_url(path: Path) -> str:
    """Return the URL of a database in a file."""
    return f"sqlite:///{path}"


def open_engine(url: str) -> Engine:
    """Return an engine; SQLite is set up for several processes that read while one writes."""
    engine = create_engine(url, pool_size=20, max_overflow=20, pool_pre_ping=False)
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _set_up_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
    return engine


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    # The driver's own BEGIN comes late and deferred: two writers that both read first then
    # fail with "database is locked", timeout or not. Transactions are begun in `_begin_sqlite`.
    connection.isolation_level = None
    connection.execute("PRAGMA journal_mode = WAL")
    # FULL: with NORMAL a power cut can take back the last commits of a WAL database.
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA foreign_keys = ON")
    connection.execute(f"PRAGMA busy_timeout = {_BUSY_TIMEOUT_MS}")


def _begin_sqlite(connection: Connection) -> None:
    looking = connection.get_execution_options().get(_LOOKING, False)
    connection.exec_driver_sql("BEGIN" if looking else "BEGIN IMMEDIATE")


class Store:
    """What the station knows: passes, recordings, calibrations, measurements, jobs, keys."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._change = sessionmaker(engine, expire_on_commit=False)
        looking = engine.execution_options(**{_LOOKING: True})
        self._look = sessionmaker(looking, expire_on_commit=False)

    @classmethod
    def open(cls, url: str) -> Self:
        """Open the store at a database URL; its schema must be up to date."""
        return cls(open_engine(url))

    @contextmanager
    def change(self) -> Generator[Session]:
        """Hold the store for writing: all that happens in the block, or nothing."""
        with self._change.begin() as session:
            yield session

    @contextmanager
    def look(self) -> Generator[Session]:
        """Read the store as it is at one moment; writers are not held up."""
        with self._look() as session:
            yield session

    def ensure_answers(self) -> None:
        """Ask the database for something, so that one out of reach shows."""
        with self.look() as session:
            session.execute(text("SELECT 1"))

    def close(self) -> None:
        """Give the connections back."""
        self._engine.dispose()
