"""The fleet's database: opened so that one that is away, or hangs, is known within seconds."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Self

from pydantic_core import from_json
from sqlalchemy import Engine, create_engine
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError
from sqlalchemy.orm import Session, sessionmaker

from station.errors import InputUnusable, StoreUnusable
from station.fleet.patience import Patience, Stop, be_patient
from station.store import database_url, file_of, looking, sqlite_engine

_STATEMENT_S = 60.0
_LOOK_S = 30.0
_CONNECT_S = 5.0
_LOCK_MS = 10_000
_GRACE_S = 5.0
"""The server says first that a statement took too long; where it does not, it hangs."""


def fleet_engine(
    url: str, *, statement_s: float = _STATEMENT_S, stop: Stop | None = None
) -> Engine:
    """Return an engine for the fleet's database.

    Parameters
    ----------
    statement_s
        A statement is given up after so long, by the server, or soon after here.
    stop
        Ends every waiting for the server.

    Raises
    ------
    InputUnusable
        If the URL is of no database that the station works with.
    """
    parsed = database_url(url)
    if parsed.get_backend_name() == "sqlite":
        return sqlite_engine(parsed, json_deserializer=from_json)
    engine = create_engine(
        parsed,
        json_deserializer=from_json,
        pool_size=2,
        pool_pre_ping=True,
        connect_args={
            "connect_timeout": int(_CONNECT_S),
            "application_name": "treadline fleet",
            # A link that is cut says nothing: the kernel would wait for a quarter of an hour.
            "tcp_user_timeout": 30_000,
            "keepalives_idle": 10,
            "keepalives_interval": 5,
            "keepalives_count": 4,
            "options": f"-c lock_timeout={_LOCK_MS} -c statement_timeout={statement_s * 1000.0:.0f}"
            " -c idle_in_transaction_session_timeout=60000 -c timezone=UTC",
        },
    )
    be_patient(engine, Patience(2.0 * _CONNECT_S, statement_s + _GRACE_S, stop))
    return engine


def is_there(url: str) -> bool:
    """Tell whether a database can be asked at all: to ask a missing SQLite file would make one.

    Raises
    ------
    InputUnusable
        If the URL is of no database that the station works with.
    """
    file = file_of(url)
    return file is None or file.exists()


class Fleet:
    """What all stations have told."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._change = sessionmaker(engine, expire_on_commit=False)
        self._look = sessionmaker(looking(engine), expire_on_commit=False)

    @classmethod
    def open(cls, url: str, *, statement_s: float = _STATEMENT_S, stop: Stop | None = None) -> Self:
        """Open the fleet's database for a station that sends; `stop` ends every waiting."""
        return cls(fleet_engine(url, statement_s=statement_s, stop=stop))

    @classmethod
    def open_to_look(cls, url: str) -> Self:
        """Open it for a person who asks: no question may hold the stations up for long."""
        return cls(fleet_engine(url, statement_s=_LOOK_S))

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


@contextmanager
def _reached() -> Generator[None]:
    """Tell a database that cannot be used now from one that does not take what it was given."""
    try:
        yield
    except (DataError, IntegrityError):
        raise
    except DBAPIError as error:
        raise unusable(error) from error


def unusable(error: DBAPIError) -> StoreUnusable:
    """Return in a line that the database cannot be used, whatever its driver calls that."""
    why = " ".join(str(error.orig).split())
    return StoreUnusable(f"the fleet's database cannot be used now ({why})")


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
