"""The tables of changes: what was written, in the order of writing, for whoever follows the store.

Triggers fill `changes`, so that no writer can forget to; see the migration that makes them.
"""

from datetime import datetime

from sqlalchemy import BigInteger, Integer, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from station.store.tables.base import Table

# SQLite counts on an INTEGER alone.
_COUNTED = BigInteger().with_variant(Integer, "sqlite")


class Change(Table):
    """That something was written to; written to again, it moves to the end of the line."""

    __tablename__ = "changes"
    # Without AUTOINCREMENT SQLite would give the last number away twice.
    __table_args__ = (UniqueConstraint("kind", "key"), {"sqlite_autoincrement": True})

    number: Mapped[int] = mapped_column(_COUNTED, primary_key=True)
    kind: Mapped[str]
    key: Mapped[str]
    changed_at: Mapped[datetime]


class StoreEpoch(Table):
    """One life of the store: another begins where it was brought back from a backup."""

    __tablename__ = "store_epochs"

    id: Mapped[int] = mapped_column(primary_key=True)
    epoch: Mapped[str]
    began_at: Mapped[datetime]


class Push(Table):
    """A batch of changes that was about to be sent, by a token that both ends keep."""

    __tablename__ = "pushes"
    __table_args__ = (UniqueConstraint("token"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    token: Mapped[str]
    number: Mapped[int] = mapped_column(_COUNTED)  # of its last change
    prepared_at: Mapped[datetime]
