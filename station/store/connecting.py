"""What each kind of database needs, so that many may read while one writes.

Whoever changes the store waits for its turn at the beginning, on either: what it read stays true
until it has written.  A check and the change that rests on it can so not be driven apart.
"""

from typing import Any

from pydantic_core import from_json
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError

from station.errors import InputUnusable
from station.store.touched import watch

WAIT_MS = 10_000
"""How long a change waits for its turn."""
_LOOKING = "station_looking"
_TURN = 0x7472_6561
"""The advisory lock that stands for the turn to write; any number, the same in every process."""


def database_url(text: str) -> URL:
    """Return the URL of a store, with the driver that the station brings along.

    Raises
    ------
    InputUnusable
        If it is no URL, or one of another database than SQLite and PostgreSQL.  The message does
        not repeat it: it may hold a password.
    """
    try:
        url = make_url(text)
    except ArgumentError:
        url = URL.create("none")
    kind = url.get_backend_name()
    if kind == "sqlite" and url.database not in {None, "", ":memory:"}:
        return url.set(drivername="sqlite")
    if kind in {"postgresql", "postgres"} and url.database:
        return url.set(drivername="postgresql+psycopg")
    raise InputUnusable(
        f"store_url of {kind}: allowed: postgresql://USER:PASSWORD@HOST/DATABASE, or "
        "sqlite:////FILE; without it the store is a file in data_dir"
    )


def open_engine(url: str) -> Engine:
    """Return an engine for a store; `looking` tells its transactions that only read.

    Raises
    ------
    InputUnusable
        If the URL is of no database that the station works with.
    """
    parsed = database_url(url)
    # Three times as fast as the standard library's, and lists and trends are made of it.
    common = {"pool_size": 20, "max_overflow": 20, "json_deserializer": from_json}
    if parsed.get_backend_name() == "sqlite":
        engine = sqlite_engine(parsed, **common)
        watch(engine)
        return engine
    engine = create_engine(
        parsed,
        **common,
        pool_pre_ping=True,  # a server may have been started again meanwhile
        connect_args={
            "connect_timeout": 5,
            "application_name": "treadline",
            "options": f"-c lock_timeout={WAIT_MS} -c timezone=UTC",
        },
    )
    event.listen(engine, "begin", _begin_postgresql)
    watch(engine)
    return engine


def sqlite_engine(url: URL, **options: Any) -> Engine:
    """Return an engine for a database in a file, whose writers take turns."""
    engine = create_engine(url, **options)
    event.listen(engine, "connect", _set_up_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def looking(engine: Engine) -> Engine:
    """Return the same engine for transactions that read one moment and change nothing."""
    if engine.dialect.name == "sqlite":
        return engine.execution_options(**{_LOOKING: True})
    # By default each statement would see another moment.
    return engine.execution_options(
        **{_LOOKING: True}, isolation_level="REPEATABLE READ", postgresql_readonly=True
    )


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    # The driver's own BEGIN comes late and deferred: two writers that both read first then
    # fail with "database is locked", timeout or not. Transactions are begun in `_begin_sqlite`.
    connection.isolation_level = None
    connection.execute(f"PRAGMA busy_timeout = {WAIT_MS}")
    connection.execute("PRAGMA journal_mode = WAL")
    # FULL: with NORMAL a power cut can take back the last commits of a WAL database.
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA foreign_keys = ON")


def _looks(connection: Connection) -> bool:
    return bool(connection.get_execution_options().get(_LOOKING, False))


def _begin_sqlite(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN" if _looks(connection) else "BEGIN IMMEDIATE")


def _begin_postgresql(connection: Connection) -> None:
    if not _looks(connection):
        connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_TURN})")
