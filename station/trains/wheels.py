"""Readings of wheels as the store keeps them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Self

from measure import Alarm, Quantity, Reading, Status, TrendPoint
from station.store import JsonObject, Measurement
from station.store.measured import Appearance

_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class Seen:
    """A wheel of a wheelset in one pass: what was read, against which reference."""

    pass_id: str
    at: datetime
    measurement_id: int
    calibration_id: str
    """Of the sensor or the rig."""
    reference: str
    readings: Mapping[Quantity, Reading]
    points: Mapping[Quantity, TrendPoint]
    """Of the quantities that were measured."""

    @classmethod
    def of(cls, found: Appearance) -> Self:
        """Take the readings out of the store's row, once for all that is made of them."""
        readings = _readings_in(found.wheel)
        day = found.opened_at.timestamp() / _DAY_S
        points = {
            quantity: TrendPoint(day, reading.value, reading.u95)
            for quantity, reading in readings.items()
            if reading.value is not None and reading.u95
        }
        return cls(
            found.pass_id,
            found.opened_at,
            found.measurement_id,
            found.calibration_id,
            found.reference,
            readings,
            points,
        )


def readings_of(row: Measurement) -> dict[Quantity, Reading]:
    """Return every quantity of a measured wheel; missing where the row has none."""
    return _readings_in(row.wheel)


def _readings_in(wheel: JsonObject) -> dict[Quantity, Reading]:
    return {quantity: _reading(wheel.get(quantity.value)) for quantity in Quantity}


def _reading(kept: JsonObject | None) -> Reading:
    # Not through its document: what the store has was checked when it was written, and a trend
    # reads thousands.
    if kept is None:
        return Reading.missing()
    return Reading(kept["value"], kept["u95"], Status(kept["status"]), Alarm(kept["alarm"]))


def surest(rows: Sequence[Measurement]) -> Measurement | None:
    """Return which of several measurements of one wheel says most, and is surest of it."""

    def doubt(row: Measurement) -> tuple[int, float, int]:
        sure = [reading.u95 for reading in readings_of(row).values() if reading.u95 is not None]
        return -len(sure), sum(sure), row.id

    return min(rows, key=doubt, default=None)


def comparable(one: Seen, other: Seen, quantity: Quantity) -> bool:
    """Tell whether a change between two readings would be the wheel's: read in the same way."""
    same_way = one.readings[quantity].status is other.readings[quantity].status
    return same_way and one.reference == other.reference
