"""Which recordings make way for others: measured ones, the oldest first, and no others.

A recording may go once what it was made for is in the store.  A pass's recording has been measured;
a calibration session's has given a calibration, and none in force came from it.  A pass that failed
stays until somebody deletes it: nothing says that anybody has looked at it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from station.settings import StorageSettings

GB = 10**9


@dataclass(frozen=True, slots=True)
class Candidate:
    """A recording that may go, and what that would free."""

    recording_id: str
    opened_at: datetime
    size_bytes: int


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
    """Return the recordings that are to go, the oldest first; none without a limit that asks.

    Parameters
    ----------
    candidates
        Recordings that may go, in any order.
    usage
        The disk before any of them goes.
    now
        The time by which they are old.
    """
    if settings.quota_gb is None and settings.keep_days is None:
        return []
    used, free = usage.recordings_bytes, usage.free_bytes
    chosen = []
    for candidate in sorted(candidates, key=lambda one: (one.opened_at, one.recording_id)):
        why = _why(candidate, used, free, settings, now)
        if why is None:
            break  # those that follow are younger, and nothing more need go
        chosen.append(Deletion(candidate, why))
        used -= candidate.size_bytes
        free += candidate.size_bytes
    return chosen


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
