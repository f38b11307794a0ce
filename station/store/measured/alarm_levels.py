"""What the wheels of passes raise, without their readings: a list shows it for many trains."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from measure import Quantity, Side
from station.store.tables import AxleWheel, JsonObject, Measurement


@dataclass(frozen=True, slots=True)
class WheelLevels:
    """One wheel of an axle of a pass: the alarm level of each quantity that was measured."""

    pass_id: str
    side: Side
    measured: bool
    levels: tuple[str, ...]
    jumps: JsonObject
    back_to_back: JsonObject | None
    """Of the axle: both wheels have it."""


def wheel_levels(session: Session, passes: Collection[str]) -> Iterator[WheelLevels]:
    """Yield the wheels of passes whose axles are kept, also those that nobody saw.

    The database takes the levels out of the rows: a wheel's readings are some kilobytes.
    """
    levels = [Measurement.wheel[quantity.value, "alarm"].as_string() for quantity in Quantity]
    query = (
        select(
            AxleWheel.pass_id,
            AxleWheel.side,
            AxleWheel.jumps,
            AxleWheel.back_to_back,
            AxleWheel.measurement_id,
            Measurement.wheel["reason"].as_string(),
            *levels,
        )
        .outerjoin(Measurement, AxleWheel.measurement_id == Measurement.id)
        .where(AxleWheel.pass_id.in_(passes))
    )
    for pass_id, side, jumps, between, measurement, reason, *found in session.execute(query):
        yield WheelLevels(
            pass_id=pass_id,
            side=side,
            measured=measurement is not None and reason is None,
            levels=tuple(level for level in found if level is not None),
            jumps=jumps,
            back_to_back=between,
        )
