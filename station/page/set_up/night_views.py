"""The nightly job: when it runs, what came of the last nights, what it decides by."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import islice

from sqlalchemy.orm import Session

from station.page.set_up.told import Setting, settings_in
from station.recalibration import Schedule
from station.settings import StationSettings
from station.store import Recalibration
from station.store.lists import recalibrations_page
from station.store.recalibrations import running_recalibration

_SHOWN = 20


@dataclass(frozen=True, slots=True)
class Night:
    """One recalibration of a sensor, as it stands."""

    id: str
    sensor: str
    at: datetime
    ended_at: datetime | None
    by: str | None
    """Who ordered it; None where it was the schedule."""
    state: str
    outcome: str | None
    reasons: Sequence[str]
    alarm: bool

    @classmethod
    def of(cls, row: Recalibration) -> "Night":
        """Return a recalibration as it is shown."""
        told_why = (row.reasons or {}).get("reasons", [])
        return cls(
            id=row.id,
            sensor=row.sensor,
            at=row.ordered_at,
            ended_at=row.ended_at,
            by=None if row.due_at is not None else row.ordered_by,
            state=row.state.value,
            outcome=row.outcome,
            reasons=[*told_why, *([row.reason] if row.reason else [])],
            alarm=bool(row.alarm),
        )


@dataclass(frozen=True, slots=True)
class NightView:
    """The nightly job.

    Attributes
    ----------
    next_due
        None where it runs on call alone.
    running
        Sensors that are being recalibrated.
    nights
        Of all sensors, the newest first.
    """

    at: str | None
    days: Sequence[str]
    zone: str
    next_due: datetime | None
    sensors: Sequence[str]
    running: frozenset[str]
    nights: Sequence[Night]
    gates: Sequence[Setting]
    policy: Sequence[Setting]


def night_view(session: Session, settings: StationSettings, now: datetime) -> NightView:
    """Return the nightly job as it stands."""
    ours = settings.recalibration
    schedule = Schedule.from_settings(ours)
    names = [sensor.id for sensor in settings.sensors]
    return NightView(
        at=None if ours.at is None else ours.at.isoformat(timespec="minutes"),
        days=ours.days,
        zone=ours.zone,
        next_due=None if schedule is None else schedule.next_due(now),
        sensors=names,
        running=frozenset(name for name in names if running_recalibration(session, name)),
        nights=_nights(session, names),
        gates=settings_in(ours.gates, "recalibration.gates"),
        policy=settings_in(ours.policy, "recalibration.policy"),
    )


def _nights(session: Session, sensors: Sequence[str]) -> list[Night]:
    rows = [
        row for name in sensors for row in recalibrations_page(session, name, limit=_SHOWN).rows
    ]
    newest_first = sorted(rows, key=lambda row: (row.ordered_at, row.sensor), reverse=True)
    return [Night.of(row) for row in islice(newest_first, _SHOWN)]
