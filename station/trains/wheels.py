"""Readings of wheels as the store keeps them."""

from collections.abc import Sequence

from measure import Quantity, Reading, TrendPoint
from station.documents import ReadingDocument
from station.store import Appearance, Measurement

_DAY_S = 86_400.0


def readings_of(row: Measurement) -> dict[Quantity, Reading]:
    """Return every quantity of a measured wheel; missing where the row has none."""
    return {quantity: _reading(row.wheel.get(quantity.value)) for quantity in Quantity}


def _reading(kept: object) -> Reading:
    if kept is None:
        return Reading.missing()
    one = ReadingDocument.model_validate(kept)
    return Reading(one.value, one.u95, one.status, one.alarm)


def surest(rows: Sequence[Measurement]) -> Measurement | None:
    """Return which of several measurements of one wheel says most, and is surest of it."""

    def doubt(row: Measurement) -> tuple[int, float, int]:
        sure = [reading.u95 for reading in readings_of(row).values() if reading.u95 is not None]
        return -len(sure), sum(sure), row.id

    return min(rows, key=doubt, default=None)


def point_of(appearance: Appearance, quantity: Quantity) -> TrendPoint | None:
    """Return a wheel's value in one pass; None where it was not measured there."""
    reading = readings_of(appearance.measurement)[quantity]
    if reading.value is None or not reading.u95:
        return None
    return TrendPoint(appearance.of_pass.opened_at.timestamp() / _DAY_S, reading.value, reading.u95)


def comparable(one: Measurement, other: Measurement, quantity: Quantity) -> bool:
    """Tell whether a change between two readings would be the wheel's: read in the same way."""
    same_way = readings_of(one)[quantity].status is readings_of(other)[quantity].status
    return same_way and one.reference == other.reference
