"""How the wheels of an axle, or of a vehicle, differ from each other."""

from collections.abc import Sequence
from dataclasses import dataclass

from measure.quantities import Quantity, Reading, Status

COMPARED = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR,
    Quantity.DIAMETER,
)
"""What is compared between wheels."""
_ORDER = (Status.OK, Status.EXTRAPOLATED, Status.REFERENCE_ASSUMED)


@dataclass(frozen=True, slots=True)
class Difference:
    """One reading less another, mm; its status is the worse of the two."""

    value_mm: float
    u95_mm: float
    status: Status


def difference(one: Reading, other: Reading) -> Difference | None:
    """Return one reading less another; None where either is missing.

    Parameters
    ----------
    one, other
        Readings of one quantity. Each has its own sensor, so their errors are independent and
        u95 is the root of the sum of squares; of two by the same sensor the calibration's part
        would cancel, and u95 is then too large, never too small.

    Examples
    --------
    >>> from measure import Alarm
    >>> left = Reading(28.5, 0.03, Status.OK, Alarm.NONE)
    >>> right = Reading(28.25, 0.04, Status.OK, Alarm.NONE)
    >>> found = difference(left, right)
    >>> found.value_mm, round(found.u95_mm, 3)
    (0.25, 0.05)
    """
    if one.value is None or other.value is None or one.u95 is None or other.u95 is None:
        return None
    return Difference(
        value_mm=one.value - other.value,
        u95_mm=float((one.u95**2 + other.u95**2) ** 0.5),
        status=max(one.status, other.status, key=_ORDER.index),
    )


@dataclass(frozen=True, slots=True)
class Spread:
    """The greatest difference in a group of wheels, and which two they are, by place.

    As the two are chosen for being the extremes, `value_mm` of equal wheels is not zero: of n of
    them it is the range of n errors.
    """

    difference: Difference
    greatest: int
    smallest: int


def spread(readings: Sequence[Reading]) -> Spread | None:
    """Return how far readings of one quantity differ; None of fewer than two that are there."""
    values = {
        place: reading.value for place, reading in enumerate(readings) if reading.value is not None
    }
    if len(values) < 2:
        return None
    greatest = max(values, key=lambda place: values[place])
    smallest = min(values, key=lambda place: values[place])
    found = difference(readings[greatest], readings[smallest])
    return None if found is None else Spread(found, greatest, smallest)
