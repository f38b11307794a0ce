"""Which recordings make way for others: measured ones, the oldest first, and no others.

A recording may go once what it was made for is in the store.  A pass's recording has been measured;
a calibration session's has given a calibration, and none in force came from it.  That of a pass
that failed stays for as long as the settings give somebody to look at it, whatever the space; so
does one that somebody uploaded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import Enum, auto

from station.settings import StorageSettings

GB = 10**9


class Kind(Enum):
    """What sort of recording it is: each has an age of its own."""

    MEASURED = auto()
    """It has given what it was made for."""
    FAILED = auto()
    """It is of a pass that failed."""
    UPLOADED = auto()
    """Somebody brought it."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A recording that may go, and what that would free."""

    recording_id: str
    opened_at: datetime
    size_bytes: int
    kind: Kind = Kind.MEASURED


@dataclass(frozen=True, slots=True)
class Usage:
    """The disk as it is."""

    recordings_bytes: int
    """All recordings, those that must stay included."""
    free_bytes: int


@dataclass(frozen=True, slots=True)
class Deletion:
    """A recording that is to go, and why."""

    candidate: Candidate
    why: str


def to_delete(
    candidates: Sequence[Candidate], usage: Usage, settings: StorageSettings, now: datetime
) -> list[Deletion]:
    """Return the recordings that are to go; none without a limit that asks.

    First those of failed passes and uploads that are old enough, then measured ones, the oldest
    first.

    Parameters
    ----------
    candidates
        Recordings that may go, in any order.
    usage
        The disk before any of them goes.
    now
        The time by which they are old.
    """
    by_age = sorted(candidates, key=lambda one: (one.opened_at, one.recording_id))
    chosen = [*_failed(by_age, settings, now), *_uploaded(by_age, settings, now)]
    if settings.quota_gb is None and settings.keep_days is None:
        return chosen
    gone = sum(deletion.candidate.size_bytes for deletion in chosen)
    used, free = usage.recordings_bytes - gone, usage.free_bytes + gone
    for candidate in (one for one in by_age if one.kind is Kind.MEASURED):
        why = _why(candidate, used, free, settings, now)
        if why is None:
            break  # those that follow are younger, and nothing more need go
        chosen.append(Deletion(candidate, why))
        used -= candidate.size_bytes
        free += candidate.size_bytes
    return chosen


def _failed(
    by_age: Sequence[Candidate], settings: StorageSettings, now: datetime
) -> list[Deletion]:
    days = settings.keep_failed_days
    if days is None:
        return []
    why = f"its pass failed; older than keep_failed_days = {days:g}"
    return [Deletion(one, why) for one in _older(by_age, Kind.FAILED, days, now)]


def _uploaded(
    by_age: Sequence[Candidate], settings: StorageSettings, now: datetime
) -> list[Deletion]:
    days = settings.keep_uploads_days
    if days is None:
        return []
    why = f"uploaded; older than keep_uploads_days = {days:g}"
    return [Deletion(one, why) for one in _older(by_age, Kind.UPLOADED, days, now)]


def _older(by_age: Sequence[Candidate], kind: Kind, days: float, now: datetime) -> list[Candidate]:
    own = (one for one in by_age if one.kind is kind)
    return [one for one in own if now - one.opened_at > timedelta(days=days)]


def _why(
    candidate: Candidate, used: int, free: int, settings: StorageSettings, now: datetime
) -> str | None:
    days, quota_gb = settings.keep_days, settings.quota_gb
    if days is not None and now - candidate.opened_at > timedelta(days=days):
        return f"older than keep_days = {days:g}"
    if quota_gb is not None and used > quota_gb * GB:
        return f"{used / GB:.2f} GB of recordings, quota_gb = {quota_gb:g}"
    if free < settings.keep_free_gb * GB:
        return f"{free / GB:.2f} GB free, keep_free_gb = {settings.keep_free_gb:g}"
    return None
