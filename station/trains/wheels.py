"""Readings of wheels as the store keeps them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from measure import Quantity, Reading, TrendPoint
from station.documents import ReadingDocument
from station.store import Appearance, Measurement, Pass

_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class Seen:
    """A wheel of a wheelset in one pass: what was read, against which reference."""

    of_pass: Pass
    reference: str
    readings: Mapping[Quantity, Reading]

    @classmethod
    def of(cls, appearance: Appearance) -> Self:
        """Take the readings out of the store's row, once for all that is made of them."""
        row = appearance.measurement
        return cls(appearance.of_pass, row.reference, readings_of(row))


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


def point_of(seen: Seen, quantity: Quantity) -> TrendPoint | None:
    """Return a wheel's value in one pass; None where it was not measured there."""
    reading = seen.readings[quantity]
    if reading.value is None or not reading.u95:
        return None
    return TrendPoint(seen.of_pass.opened_at.timestamp() / _DAY_S, reading.value, reading.u95)


def comparable(one: Seen, other: Seen, quantity: Quantity) -> bool:
    """Tell whether a change between two readings would be the wheel's: read in the same way."""
    same_way = one.readings[quantity].status is other.readings[quantity].status
    return same_way and one.reference == other.reference
