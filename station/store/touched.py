"""Which tables are read and written, as the statements that reach the database say.

By the names that stand in a statement: a name too many makes an answer be looked up once more, a
name too few cannot be, whatever library or hand wrote the statement.
"""

import re
from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import Any, Final

from sqlalchemy import BigInteger, Connection, Engine, event, text
from sqlalchemy.orm import Mapped, Session, mapped_column

from station.store.tables import Table

_WRITTEN: Final = "station_tables_written"
_READ: ContextVar[set[str] | None] = ContextVar("station_tables_read", default=None)
_COUNT_ON: Final = text(
    "INSERT INTO table_revisions (name, number) VALUES (:name, 1) "
    "ON CONFLICT (name) DO UPDATE SET number = table_revisions.number + 1"
)


class TableRevision(Table):
    """How many transactions have written to a table."""

    __tablename__ = "table_revisions"

    name: Mapped[str] = mapped_column(primary_key=True)
    number: Mapped[int] = mapped_column(BigInteger)


def watch(engine: Engine) -> None:
    """Have the statements of an engine noted."""
    event.listen(engine, "begin", _forget)
    event.listen(engine, "before_cursor_execute", _note)


@contextmanager
def tables_read() -> Generator[set[str]]:
    """Yield a set that fills with the tables read within the block, in threads it starts too."""
    names: set[str] = set()
    token = _READ.set(names)
    try:
        yield names
    finally:
        _READ.reset(token)


def count_changes(session: Session) -> None:
    """Count the tables on that a transaction has written to, as its last deed."""
    session.flush()
    written = session.connection().info.pop(_WRITTEN, None)
    if written:
        session.execute(_COUNT_ON, [{"name": name} for name in sorted(written)])


def _forget(connection: Connection) -> None:
    connection.info.pop(_WRITTEN, None)  # of a transaction that was taken back


def _note(connection: Connection, _cursor: Any, statement: str, *_others: Any) -> None:
    reads, names = _told_by(statement)
    if not reads and names:
        connection.info.setdefault(_WRITTEN, set()).update(names)
    read = _READ.get()
    if read is not None:
        read.update(names)


@lru_cache(maxsize=1024)
def _told_by(statement: str) -> tuple[bool, frozenset[str]]:
    """Return whether a statement only reads, and the tables that it names."""
    words = re.findall(r"\w+", statement)
    known = Table.metadata.tables.keys() - {TableRevision.__tablename__}
    return words[:1] == ["SELECT"], frozenset(known & set(words))
