"""Following the store: what changed since a number, and which life of the store it is."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from uuid import uuid4

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from station.store.tables import Change, Push, StoreEpoch

_PUSHES_KEPT = 10_000
"""Weeks of them; whoever was restored from further back is sent everything."""


class ChangeKind(StrEnum):
    """What was written to."""

    PASS = "pass"
    """The pass itself, its axles or its measurements; the key is the pass's."""
    ACTIVATION = "activation"
    RIG_ACTIVATION = "rig_activation"
    RECALIBRATION = "recalibration"


@dataclass(frozen=True, slots=True)
class ChangesLeft:
    """How many changes come after a number, and when the oldest of them was made."""

    count: int
    since: datetime | None


def changes_after(session: Session, number: int, *, limit: int) -> Sequence[Change]:
    """Return what changed after a change, in the order in which it was committed.

    The writers of a store take turns, so that a number never turns up below one that was seen.
    """
    query = select(Change).where(Change.number > number).order_by(Change.number).limit(limit)
    return session.scalars(query).all()


def changes_left(session: Session, number: int) -> ChangesLeft:
    """Return what is left to be sent after a change."""
    left = Change.number > number
    count = session.scalar(select(func.count()).select_from(Change).where(left)) or 0
    first = select(Change.changed_at).where(left).order_by(Change.number).limit(1)
    return ChangesLeft(count, session.scalar(first))


def note_push(session: Session, number: int, *, at: datetime) -> str:
    """Keep that changes up to a number are about to be sent; return the token to send along."""
    push = Push(token=uuid4().hex, number=number, prepared_at=at)
    session.add(push)
    session.flush()
    session.execute(delete(Push).where(Push.id <= push.id - _PUSHES_KEPT))
    return push.token


def knows_push(session: Session, token: str) -> bool:
    """Tell whether this store sent the batch of a token; one brought back from before did not."""
    return session.scalar(select(Push.id).where(Push.token == token)) is not None


def store_epoch(session: Session) -> str | None:
    """Return which life of the store this is; None before anybody asked for it to be counted."""
    return session.scalar(select(StoreEpoch.epoch).order_by(StoreEpoch.id.desc()).limit(1))


def begin_epoch(session: Session, *, after: str | None, at: datetime) -> str:
    """Begin another life of the store after the one that was seen, and return its name.

    Where somebody else began it meanwhile, it is theirs.
    """
    present = store_epoch(session)
    if present is not None and present != after:
        return present
    epoch = StoreEpoch(epoch=uuid4().hex, began_at=at)
    session.add(epoch)
    session.flush()
    return epoch.epoch
