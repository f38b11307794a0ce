"""The fleet's database: opened so that one that is away, or hangs, is known within seconds."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Self

from pydantic_core import from_json
from sqlalchemy import Engine, create_engine, event
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError
from sqlalchemy.orm import Session, sessionmaker

from station.errors import InputUnusable, StoreUnusable
from station.store import database_url

_STATEMENT_MS = 60_000
_LOOK_MS = 30_000
_LOCK_MS = 10_000


def fleet_engine(url: str, *, statement_ms: int = _STATEMENT_MS) -> Engine:
    """Return an engine for the fleet's database.

    Raises
    ------
    InputUnusable
        If the URL is of no database that the station works with.
    """
    parsed = database_url(url)
    if parsed.get_backend_name() == "sqlite":
        engine = create_engine(parsed, json_deserializer=from_json)
        event.listen(engine, "connect", _set_up_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
        return engine
    return create_engine(
        parsed,
        json_deserializer=from_json,
        pool_size=2,
        pool_pre_ping=True,
        connect_args={
            "connect_timeout": 5,
            "application_name": "treadline fleet",
            # A link that is cut says nothing: the kernel would wait for a quarter of an hour.
            "tcp_user_timeout": 30_000,
            "keepalives_idle": 10,
            "keepalives_interval": 5,
            "keepalives_count": 4,
            "options": f"-c lock_timeout={_LOCK_MS} -c statement_timeout={statement_ms}"
            " -c idle_in_transaction_session_timeout=60000 -c timezone=UTC",
        },
    )


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # transactions are begun in `_begin_sqlite`
    connection.execute(f"PRAGMA busy_timeout = {_LOCK_MS}")
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA foreign_keys = ON")


def _begin_sqlite(connection: Any) -> None:
    looks = connection.get_execution_options().get("fleet_looks", False)
    connection.exec_driver_sql("BEGIN" if looks else "BEGIN IMMEDIATE")


class Fleet:
    """What all stations have told."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._change = sessionmaker(engine, expire_on_commit=False)
        self._look = sessionmaker(_looking(engine), expire_on_commit=False)

    @classmethod
    def open(cls, url: str) -> Self:
        """Open the fleet's database for a station that sends."""
        return cls(fleet_engine(url))

    @classmethod
    def open_to_look(cls, url: str) -> Self:
        """Open it for a person who asks: no question may hold the stations up for long."""
        return cls(fleet_engine(url, statement_ms=_LOOK_MS))

    @contextmanager
    def change(self) -> Generator[Session]:
        """Write: all that happens in the block, or nothing.

        Raises
        ------
        StoreUnusable
            If the database does not answer.
        """
        with _reached(), self._change.begin() as session:
            yield session

    @contextmanager
    def look(self) -> Generator[Session]:
        """Read one moment.

        Raises
        ------
        StoreUnusable
            If the database does not answer.
        """
        with _reached(), self._look() as session:
            yield session

    def close(self) -> None:
        """Give the connections back."""
        self._engine.dispose()


def _looking(engine: Engine) -> Engine:
    if engine.dialect.name == "sqlite":
        return engine.execution_options(fleet_looks=True)
    return engine.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)


@contextmanager
def _reached() -> Generator[None]:
    """Tell a database that cannot be used now from one that does not take what it was given."""
    try:
        yield
    except (DataError, IntegrityError):
        raise
    except DBAPIError as error:
        why = " ".join(str(error.orig).split())
        raise StoreUnusable(f"the fleet's database cannot be used now ({why})") from error


def ensure_given(url: str | None) -> str:
    """Return the URL of the fleet.

    Raises
    ------
    InputUnusable
        If there is none.
    """
    if url is None:
        raise InputUnusable(
            "no fleet is named; give --url postgresql://USER:PASSWORD@HOST/DATABASE, or set url in "
            "[fleet] of station.toml or STATION_FLEET_URL in the environment"
        )
    return url
