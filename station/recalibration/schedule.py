"""When a recalibration is due by the station's own clock."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from typing import Self
from zoneinfo import ZoneInfo

from station.settings import DAYS, RecalibrationSettings

_WEEK = 8
"""Days within which every schedule is due once, counted with both ends."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """A time of the day on some days of the week, in a zone.

    A time that a change of the clocks leaves out is due as long after midnight as on other days:
    02:30 becomes 03:30 by the new clock. One that comes twice is due the first time.

    Attributes
    ----------
    at
        Time of the day, without a zone.
    weekdays
        0 for Monday to 6.
    zone
        What both are counted in.
    """

    at: time
    weekdays: frozenset[int]
    zone: ZoneInfo

    def __post_init__(self) -> None:
        if not (self.weekdays and self.weekdays <= set(range(7))):
            raise ValueError(f"weekdays must be some of 0 to 6, got {sorted(self.weekdays)}")

    @classmethod
    def from_settings(cls, settings: RecalibrationSettings) -> Self | None:
        """Return the schedule of the settings; None where it runs on call alone."""
        if settings.at is None:
            return None
        weekdays = frozenset(DAYS.index(day) for day in settings.days)
        return cls(settings.at, weekdays, ZoneInfo(settings.zone))

    def last_due(self, now: datetime) -> datetime:
        """Return the last moment, not after `now`, at which it was due.

        >>> nightly = Schedule(time(2, 30), frozenset(range(7)), ZoneInfo("Europe/Berlin"))
        >>> nightly.last_due(datetime(2026, 3, 29, 12, tzinfo=UTC)).isoformat()
        '2026-03-29T01:30:00+00:00'
        """
        return next(due for due in self._moments(now, -1) if due <= now)

    def next_due(self, now: datetime) -> datetime:
        """Return the first moment after `now` at which it is due."""
        return next(due for due in self._moments(now, 1) if due > now)

    def _moments(self, now: datetime, step: int) -> Iterator[datetime]:
        # From the day on the other side: the local day may be another than that of the moment.
        today = now.astimezone(self.zone).date() - timedelta(days=step)
        for days in range(_WEEK + 2):
            day = today + timedelta(days=step * days)
            if day.weekday() in self.weekdays:
                yield self._moment(day)

    def _moment(self, day: date) -> datetime:
        # With fold 0 the zone reads a time left out by the offset before the change, and one that
        # comes twice as the first.
        return datetime.combine(day, self.at, tzinfo=self.zone).astimezone(UTC)


def owed(schedule: Schedule, *, since: datetime, now: datetime) -> datetime | None:
    """Return the moment of the recalibration that is owed, or None.

    However many nights were missed, one recalibration makes up for them: it tells how the sensor
    is now, which none can tell of a night that has gone.

    Parameters
    ----------
    since
        The later of two: the moment up to which recalibrations are settled, and that at which the
        calibration in force came into it.
    now
        The present moment.
    """
    due = schedule.last_due(now)
    return due if due > since else None
