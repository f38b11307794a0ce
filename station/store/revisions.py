"""Whether anybody has changed the store since it was last looked at, without looking into it."""

import sqlite3
from types import TracebackType
from typing import Self

from sqlalchemy import URL


class Revisions:
    """Tells a number that is another one after every change, whoever made it.

    SQLite counts the commits of all processes for each connection that makes none itself
    (`PRAGMA data_version`), at the cost of some microseconds and without a lock.  PostgreSQL has
    no such number: there nothing is known, and everything is to be looked up.

    Used by one thread at a time.
    """

    def __init__(self, url: URL) -> None:
        self._file = url.database if url.get_backend_name() == "sqlite" else None
        self._connection: sqlite3.Connection | None = None

    def now(self) -> int | None:
        """Return the present number; None where nothing is known."""
        if self._file is None:
            return None
        try:
            if self._connection is None:
                # Never waits: who cannot be told at once looks the answer up.
                self._connection = sqlite3.connect(
                    self._file, timeout=0.0, isolation_level=None, check_same_thread=False
                )
            (number,) = self._connection.execute("PRAGMA data_version").fetchone()
        except sqlite3.Error:
            self.close()
            return None
        return int(number)

    def close(self) -> None:
        """Give the connection back."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
