"""How long ago something was last heard of a recording that is being made.

The capture processes tell it, by clocks that nobody sets: they outlive the API process, so an API
that is started again and again does not make a train young again.  The clock of the host is asked
only for what no capture process tells, and only once: it may be set meanwhile.
"""

import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime

from station.capture import CaptureStatus


@dataclass(frozen=True, slots=True)
class Heard:
    """What is known of a pass or session whose sensors record."""

    age_s: float
    """Since it was armed."""
    silent_s: float
    """Since the last frame of any sensor; since it was armed, where none has come."""
    any_frame: bool
    deaf: tuple[str, ...]
    """Sensors that do not record it now."""


@dataclass(slots=True)
class _Known:
    began_s: float
    last_s: float
    any_frame: bool = False


class Hearing:
    """Remembers of each recording what its sensors told, as long as it lasts."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._known: dict[str, _Known] = {}

    def listen(
        self,
        name: str,
        statuses: Mapping[str, CaptureStatus | None],
        *,
        opened_at: datetime,
        now: datetime,
    ) -> Heard:
        """Take in what the sensors of a recording tell.

        Parameters
        ----------
        name
            Of the pass or session, unlike any other's.
        statuses
            Of each of its sensors that records it; None of one that does not.
        opened_at, now
            By the clock of the host.
        """
        now_s = self._clock()
        known = self._known.get(name)
        told = [each for each in statuses.values() if each is not None]
        if known is None:
            known = self._known[name] = _first(now_s, told, max(0.0, _seconds(opened_at, now)))
        for each in told:
            if each.recording_s is not None:
                known.began_s = min(known.began_s, now_s - each.recording_s)
            if each.silent_s is not None:
                known.last_s = max(known.last_s, now_s - each.silent_s)
            known.any_frame |= each.recorded > 0
        return Heard(
            age_s=now_s - known.began_s,
            silent_s=now_s - known.last_s,
            any_frame=known.any_frame,
            deaf=tuple(sensor for sensor, each in statuses.items() if each is None),
        )

    def forget_all_but(self, names: Collection[str]) -> None:
        """Forget the recordings that have ended."""
        self._known = {name: known for name, known in self._known.items() if name in names}


def _first(now_s: float, told: Iterable[CaptureStatus], open_s: float) -> _Known:
    ages_s = [each.recording_s for each in told if each.recording_s is not None]
    began_s = now_s - (max(ages_s) if ages_s else open_s)
    return _Known(began_s, began_s)


def _seconds(since: datetime, until: datetime) -> float:
    return (until - since).total_seconds()
