"""The pass in progress, and the last one: their counts, their wheels, their alarms."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any, Final, Self

from sqlalchemy import Select, case, func, select
from sqlalchemy.orm import Session

from measure import Alarm, Quantity, Reading
from station.capture import CaptureStatus
from station.page.now.sensors import Doing, doing_of
from station.store import HELD, Measurement, Pass, Recording, pass_in_progress, recordings_of
from station.store.lists import passes_page
from station.store.measured import wheels_of
from station.trains import AxleAlarm, readings_of, train_picture

SHOWN: Final = (Quantity.TREAD_WEAR, Quantity.FLANGE_HEIGHT, Quantity.FLANGE_THICKNESS_10)
"""What is shown of a wheel at first sight."""
_MOST_WHEELS: Final = 12
_RECENT: Final = 8
"""Among so many of the newest passes the last one that is not in progress is found: one is."""
_GRAVEST: Final = (Alarm.ALARM, Alarm.WARNING, Alarm.NONE)


@dataclass(frozen=True, slots=True)
class WheelNow:
    """A wheel as measured."""

    id: int
    sensor: str
    """Or the rig."""
    frame: int
    readings: Mapping[Quantity, Reading]
    reason: str | None
    """Why it could not be measured."""

    @classmethod
    def of(cls, row: Measurement) -> Self:
        """Return a wheel of the store."""
        found = readings_of(row)
        readings = {quantity: found[quantity] for quantity in SHOWN}
        return cls(row.id, row.sensor, row.frame, readings, row.wheel.get("reason"))


@dataclass(frozen=True, slots=True)
class SensorCount:
    """What a sensor has of a pass."""

    sensor: str
    doing: Doing | None
    """What it does about the pass now; None where that is over."""
    recorded: int | None
    lost: int | None
    """Lost, or refused as incomplete."""
    expected: int | None
    """Triggers as the controller counted them."""
    silent_s: float | None = None
    """How long ago its last frame came."""

    @classmethod
    def of(cls, row: Recording, status: CaptureStatus | None) -> Self:
        """Return what a recording has, by its capture process while that makes it."""
        if row.closed_at is None:
            if status is None or status.session_id != row.pass_id:
                return cls(row.sensor, doing_of(status), None, None, row.expected)
            lost = status.lost + status.refused
            doing = doing_of(status)
            return cls(row.sensor, doing, status.recorded, lost, row.expected, status.silent_s)
        lost_of_row = None if row.lost is None else row.lost + (row.refused or 0)
        return cls(row.sensor, None, row.recorded, lost_of_row, row.expected)


@dataclass(frozen=True, slots=True)
class PassNow:
    """A pass at one moment."""

    row: Pass
    counts: Sequence[SensorCount]
    measured: int
    unmeasurable: int
    wheels: Sequence[WheelNow]
    """The last ones measured, the newest first."""
    alarms: Sequence[AxleAlarm] = ()
    """Once all of it is measured."""

    @property
    def lost(self) -> int:
        """Frames lost by all sensors."""
        return sum(each.lost or 0 for each in self.counts)

    @property
    def recorded(self) -> int:
        """Frames recorded by all sensors."""
        return sum(each.recorded or 0 for each in self.counts)

    @property
    def level(self) -> Alarm:
        """The gravest of its alarms."""
        raised = {each.level for each in self.alarms}
        return next((each for each in _GRAVEST if each in raised), Alarm.NONE)


def pass_now(session: Session, statuses: Mapping[str, CaptureStatus]) -> PassNow | None:
    """Return the pass in progress, or None."""
    row = pass_in_progress(session)
    return None if row is None else _view(session, row, statuses)


def last_pass(session: Session) -> PassNow | None:
    """Return the pass that ended last, or None before the first."""
    page = passes_page(session, limit=_RECENT)
    row = next((each for each in page.rows if each.state not in HELD), None)
    if row is None:
        return None
    alarms = train_picture(session, row, wheels_of(session, row)).alarms
    return replace(_view(session, row, {}), alarms=alarms)


def _view(session: Session, row: Pass, statuses: Mapping[str, CaptureStatus]) -> PassNow:
    # Counted by the database: a long train has thousands of wheels, and this is asked every second.
    unmeasured = case((Measurement.wheel["reason"].as_string().is_not(None), 1), else_=0)
    of_it = _in_force(select(func.count(), func.coalesce(func.sum(unmeasured), 0)), row)
    wheels, unmeasurable = session.execute(of_it).one()
    newest = _in_force(select(Measurement), row).order_by(Measurement.id.desc())
    return PassNow(
        row=row,
        counts=[
            SensorCount.of(each, statuses.get(each.sensor)) for each in recordings_of(session, row)
        ],
        measured=wheels - unmeasurable,
        unmeasurable=unmeasurable,
        wheels=[WheelNow.of(each) for each in session.scalars(newest.limit(_MOST_WHEELS))],
    )


def _in_force(query: Select[Any], row: Pass) -> Select[Any]:
    """Return a query for the wheels of a pass by what was in force when it was recorded."""
    rig = Measurement.rig_calibration_id
    return (
        query
        .select_from(Measurement)
        .join(Recording, Measurement.recording_id == Recording.id)
        .where(Measurement.pass_id == row.id)
        .where(Measurement.calibration_id == Recording.calibration_id)
        .where(rig.is_not_distinct_from(Recording.rig_calibration_id))
    )


def suggested_id(now: datetime) -> str:
    """Return a name for a pass that nobody has had: its moment, UTC.

    >>> from datetime import UTC
    >>> suggested_id(datetime(2026, 7, 1, 12, 0, 5, tzinfo=UTC))
    '20260701-120005'
    """
    return now.strftime("%Y%m%d-%H%M%S")
