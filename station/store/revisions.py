"""Whether what an answer was made of has changed since, without looking into the store."""

import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from sqlalchemy import URL

_BY_OTHERS = ""
"""Stands for changes by a hand that does not count the tables on: all may have changed."""


@dataclass(frozen=True, slots=True, eq=False)
class Revision:
    """The store at one moment, as far as its tables' counts tell."""

    numbers: Mapping[str, int]

    def of(self, tables: Iterable[str]) -> Mapping[str, int]:
        """Return what stands for the present content of some tables."""
        return {name: self.numbers.get(name, 0) for name in {_BY_OTHERS, *tables}}


class Revisions:
    """Tells the present revision of a store; the same object as long as nobody has written.

    SQLite counts the commits of all processes for each connection that makes none itself
    (`PRAGMA data_version`), at the cost of some microseconds and without a lock; only after a
    commit are the tables' counts read.  PostgreSQL has no such number: there nothing is known, and
    everything is to be looked up.

    Used by one thread at a time.
    """

    def __init__(self, url: URL) -> None:
        self._file = url.database if url.get_backend_name() == "sqlite" else None
        self._connection: sqlite3.Connection | None = None
        self._version: int | None = None
        self._last = Revision({})

    def now(self) -> Revision | None:
        """Return the present revision; None where nothing is known."""
        if self._file is None:
            return None
        try:
            if self._connection is None:
                # Never waits: who cannot be told at once looks the answer up.
                self._connection = sqlite3.connect(
                    self._file, timeout=0.0, isolation_level=None, check_same_thread=False
                )
            self._look(self._connection)
        except sqlite3.Error:
            self.close()
            return None
        return self._last

    def _look(self, connection: sqlite3.Connection) -> None:
        (version,) = connection.execute("PRAGMA data_version").fetchone()
        if version == self._version:
            return
        found = dict(connection.execute("SELECT name, number FROM table_revisions"))
        by_others = self._last.numbers.get(_BY_OTHERS, 0)
        if found | {_BY_OTHERS: by_others} == self._last.numbers:
            by_others += 1
        self._version, self._last = version, Revision(found | {_BY_OTHERS: by_others})

    def close(self) -> None:
        """Give the connection back."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        # Another connection counts otherwise: what was kept before is not to be believed.
        by_others = self._last.numbers.get(_BY_OTHERS, 0) + 1
        self._version, self._last = None, Revision({_BY_OTHERS: by_others})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
