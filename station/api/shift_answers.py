"""What comes out over HTTP of what a calibration would make of readings."""

from typing import Self

from measure import Quantity
from station.api.answers import Out
from station.operations import CalibrationShifts, ShiftOfReading


class ReadingShiftModel(Out):
    """One quantity; mm, uncertainties of 95 %."""

    quantity: Quantity
    shift_mm: float
    """By how much a reading is larger with this calibration than with the one in force."""
    u95_mm: float
    """What both calibrations leave open of the shift, taken as independent."""
    within: bool
    """Whether the shift is no more than that."""
    reading_u95_mm: float | None
    """What the wheel's own reading was given with; null where it had none."""

    @classmethod
    def of(cls, found: ShiftOfReading) -> Self:
        shift = found.shift
        return cls(
            quantity=shift.quantity,
            shift_mm=shift.by_mm,
            u95_mm=shift.u95_mm,
            within=shift.within,
            reading_u95_mm=found.reading_u95_mm,
        )


class ShiftsModel(Out):
    """By how much readings shift once a calibration is in force."""

    calibration: str
    against: str | None
    """What is in force; null where that is this calibration, or nothing."""
    measurement: int | None
    """The wheel that it is told on: the last one its sensor, or its rig, measured."""
    pass_id: str | None
    shifts: list[ReadingShiftModel]
    within: bool | None
    """Whether no reading shifts by more than both calibrations leave open; null without a shift."""
    reason: str | None
    """Why there are none."""

    @classmethod
    def of(cls, calibration: str, found: CalibrationShifts | None) -> Self:
        if found is None:
            return cls(
                calibration=calibration,
                against=None,
                measurement=None,
                pass_id=None,
                shifts=[],
                within=None,
                reason="nothing else is in force to compare with",
            )
        return cls(
            calibration=calibration,
            against=found.against,
            measurement=found.measurement,
            pass_id=found.pass_id,
            shifts=[ReadingShiftModel.of(each) for each in found.shifts],
            within=found.within if found.shifts else None,
            reason=found.reason,
        )
