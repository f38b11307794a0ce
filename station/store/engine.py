"""The two ways to use the store: to change it, and to look."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from sqlalchemy import Engine, text
from sqlalchemy.exc import InterfaceError, OperationalError
from sqlalchemy.orm import Session, sessionmaker

from station.errors import StoreUnusable
from station.store.connecting import looking, open_engine
from station.store.revisions import Revisions
from station.store.touched import count_changes


def sqlite_url(path: Path) -> str:
    """Return the URL of a database in a file."""
    return f"sqlite:///{path}"


class Store:
    """What the station knows: passes, recordings, calibrations, measurements, jobs, keys."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._change = sessionmaker(engine, expire_on_commit=False)
        self._look = sessionmaker(looking(engine), expire_on_commit=False)

    @classmethod
    def open(cls, url: str) -> Self:
        """Open the store at a database URL; its schema must be up to date."""
        return cls(open_engine(url))

    @contextmanager
    def change(self) -> Generator[Session]:
        """Hold the store for writing: all that happens in the block, or nothing.

        Raises
        ------
        StoreUnusable
            If the database does not answer, or others hold it for 10 s.
        """
        with _reached(), self._change.begin() as session:
            yield session
            count_changes(session)

    @contextmanager
    def look(self) -> Generator[Session]:
        """Read the store as it is at one moment; writers are not held up.

        Raises
        ------
        StoreUnusable
            If the database does not answer.
        """
        with _reached(), self._look() as session:
            yield session

    def ensure_answers(self) -> None:
        """Ask the database for something, so that one out of reach shows."""
        with self.look() as session:
            session.execute(text("SELECT 1"))

    def revisions(self) -> Revisions:
        """Return what tells whether the store has changed."""
        return Revisions(self._engine.url)

    def close(self) -> None:
        """Give the connections back."""
        self._engine.dispose()


@contextmanager
def _reached() -> Generator[None]:
    """Say in one line that the database does not let anybody in, whatever its driver calls that."""
    try:
        yield
    except (OperationalError, InterfaceError) as error:
        why = " ".join(str(error.orig).split())
        raise StoreUnusable(f"the store cannot be used now ({why}); try again") from error
