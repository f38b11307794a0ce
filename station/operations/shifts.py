"""What a calibration would make of readings, beside the one in force: what that is told on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from measure import Quantity, ReadingShifts, Shift
from station.documents import (
    CalibrationDocument,
    ProfileDocument,
    RigDocument,
    StandingDocument,
    WheelDocument,
)
from station.errors import StateConflict
from station.pipeline import SeenBefore
from station.settings import StationSettings
from station.store import Calibration, Measurement, RigCalibration, active, active_rig, the
from station.store.measured import profiles_of

_LOOKED_THROUGH = 50
"""Wheels, from the last one back, of which one must have shown where it stood."""


@dataclass(frozen=True, slots=True)
class ShiftOfReading:
    """A shift, and the uncertainty that the wheel's own reading was given with; mm, 95 %."""

    shift: Shift
    reading_u95_mm: float | None


@dataclass(frozen=True, slots=True)
class CalibrationShifts:
    """By how much readings shift with a calibration.

    Attributes
    ----------
    against
        The calibration in force.
    measurement, pass_id
        The wheel that it is told on; None where there is none.
    shifts
        None where `reason` says why.
    """

    against: str
    measurement: int | None
    pass_id: str | None
    shifts: tuple[ShiftOfReading, ...]
    reason: str | None

    @property
    def within(self) -> bool:
        """Whether no reading shifts by more than both calibrations leave open."""
        return all(each.shift.within for each in self.shifts)


@dataclass(frozen=True, slots=True)
class ShiftsToTell:
    """A calibration, what is in force instead, and a wheel to tell the shifts on."""

    new: CalibrationDocument
    against: str
    wheel: Measurement | None
    seen: SeenBefore | None

    def told(self, found: ReadingShifts) -> CalibrationShifts:
        """Return the shifts beside the wheel's own readings."""
        row = self.wheel
        stated = {} if row is None else _stated(row)
        return CalibrationShifts(
            against=self.against,
            measurement=None if row is None else row.id,
            pass_id=None if row is None else row.pass_id,
            shifts=tuple(ShiftOfReading(each, stated.get(each.quantity)) for each in found.shifts),
            reason=found.reason,
        )


def shifts_to_tell(
    session: Session, settings: StationSettings, calibration_id: str
) -> ShiftsToTell | None:
    """Return what to tell the shifts of readings on; None where nothing else is in force.

    Raises
    ------
    NotFound
        If there is no such calibration.
    StateConflict
        If it is not ready.
    """
    row = the(session, Calibration, calibration_id)
    if row.document is None:
        raise StateConflict(
            f"calibration {calibration_id} is {row.state}; only a ready one can be compared",
            state=row.state,
        )
    activation = active(session, row.sensor)
    if activation is None or activation.calibration_id == calibration_id:
        return None
    new = CalibrationDocument.model_validate_json(row.document)
    rig = _rig_of(session, settings, row.sensor)
    wheel = _last_wheel(session, row.sensor if rig is None else rig.rig)
    present = _present(session, [row.sensor] if rig is None else rig.names)
    seen = None if wheel is None else _seen(session, wheel, present, rig, settings.reference)
    return ShiftsToTell(new, activation.calibration_id, wheel, seen)


def _rig_of(session: Session, settings: StationSettings, sensor: str) -> RigDocument | None:
    """Return the rig in force that a sensor measures on; None of one by itself."""
    rig = settings.rig_with(sensor)
    activation = None if rig is None else active_rig(session, rig.id)
    if activation is None:
        return None
    document = the(session, RigCalibration, activation.rig_calibration_id).document
    return RigDocument.model_validate_json(document or "")


def _present(session: Session, sensors: Sequence[str]) -> tuple[CalibrationDocument, ...]:
    in_force = [active(session, name) for name in sensors]
    rows = [the(session, Calibration, each.calibration_id) for each in in_force if each is not None]
    return tuple(CalibrationDocument.model_validate_json(row.document or "") for row in rows)


def _last_wheel(session: Session, looker: str) -> Measurement | None:
    """Return the last wheel that a sensor or rig measured and saw the flange back of."""
    rows = session.scalars(
        select(Measurement)
        .where(Measurement.sensor == looker)
        .order_by(Measurement.id.desc())
        .limit(_LOOKED_THROUGH)
    )
    return next((row for row in rows if row.wheel.get("standing")), None)


def _seen(
    session: Session,
    wheel: Measurement,
    present: tuple[CalibrationDocument, ...],
    rig: RigDocument | None,
    reference: str,
) -> SeenBefore | None:
    profile = profiles_of(session, [wheel]).get(wheel.id)
    if profile is None:
        return None
    standing = StandingDocument.model_validate(wheel.wheel["standing"])
    return SeenBefore(
        profile=ProfileDocument.model_validate(profile),
        back_mm=standing.backs[0].back_mm,
        present=present,
        rig=rig,
        reference=reference,
    )


def _stated(row: Measurement) -> Mapping[Quantity, float]:
    readings = WheelDocument.model_validate(row.wheel).readings
    return {name: each.u95 for name, each in readings.items() if each.u95 is not None}
