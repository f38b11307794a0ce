"""Answers kept for calls that come again: what a caller that retries blindly has done only once."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import Enum, auto

from sqlalchemy import delete
from sqlalchemy.orm import Session

from station.store.tables import JsonObject, KeptAnswer

KEPT_FOR = timedelta(hours=24)


@dataclass(frozen=True, slots=True)
class Call:
    """A call that is not to be made twice."""

    caller: str
    key: str
    """Its Idempotency-Key."""
    fingerprint: str
    """SHA-256 of method, address and body."""


class Standing(Enum):
    """Where the key of a call stands."""

    NEW = auto()
    UNANSWERED = auto()
    """Being answered; or never answered, by a process that died of it or failed in it."""
    ANSWERED = auto()
    OF_ANOTHER_CALL = auto()


def begin_call(session: Session, call: Call, *, at: datetime) -> tuple[Standing, KeptAnswer]:
    """Note a call that is about to be made; or return what is kept of it.

    What is older than a day is forgotten on the way.
    """
    session.execute(delete(KeptAnswer).where(KeptAnswer.asked_at < at - KEPT_FOR))
    kept = session.get(KeptAnswer, (call.caller, call.key))
    if kept is None:
        new = KeptAnswer(
            caller=call.caller, key=call.key, fingerprint=call.fingerprint, asked_at=at
        )
        session.add(new)
        return Standing.NEW, new
    if kept.fingerprint != call.fingerprint:
        return Standing.OF_ANOTHER_CALL, kept
    return (Standing.UNANSWERED if kept.status is None else Standing.ANSWERED), kept


def keep_answer(
    session: Session, call: Call, *, status: int, headers: JsonObject, body: bytes
) -> None:
    """Keep the answer to a call that was begun."""
    kept = session.get(KeptAnswer, (call.caller, call.key))
    if kept is not None:
        kept.status, kept.headers, kept.body = status, headers, body


def forget_call(session: Session, call: Call) -> None:
    """Forget a call that changed nothing, so that it can be made again."""
    session.execute(
        delete(KeptAnswer).where(KeptAnswer.caller == call.caller, KeptAnswer.key == call.key)
    )
