"""How the wheels of a wheelset change over its passes."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from measure import Alarm, Limits, Quantity, Rate, Side, Status, TrendPoint, fit_trend
from station.errors import NotFound
from station.store.measured import history_of
from station.trains.jumps import jump_to
from station.trains.wheels import Seen


@dataclass(frozen=True, slots=True)
class TrendValue:
    """A value of one pass; `jump` is the change where it jumped there, mm."""

    pass_id: str
    at: datetime
    measurement_id: int
    calibration_id: str
    """Of the sensor or the rig that it was measured with."""
    value: float
    u95: float
    status: Status
    alarm: Alarm
    jump: float | None


@dataclass(frozen=True, slots=True)
class QuantityTrend:
    """The values of one quantity, oldest first, and the line through those since the last jump."""

    values: tuple[TrendValue, ...]
    fitted: int
    """Values that the rates rest on."""
    per_day: Rate | None
    per_pass: Rate | None
    scatter: float | None


@dataclass(frozen=True, slots=True)
class SideTrend:
    """One wheel of a wheelset."""

    side: Side
    passes: int
    quantities: dict[Quantity, QuantityTrend]


@dataclass(frozen=True, slots=True)
class WheelsetTrend:
    """Both wheels of a wheelset."""

    wheelset: str
    sides: tuple[SideTrend, ...]


def wheelset_trend(session: Session, wheelset: str, limits: Limits, *, most: int) -> WheelsetTrend:
    """Return how a wheelset changed over its last passes, `most` of each wheel.

    Raises
    ------
    NotFound
        If no pass has measured it: none was certain to be it.
    """
    histories = {
        side: [Seen.of(each) for each in history_of(session, wheelset, side=side, most=most)]
        for side in Side
    }
    if not any(histories.values()):
        raise NotFound(f"wheelset {wheelset!r}: no measured pass has it at a place that is certain")
    return WheelsetTrend(
        wheelset,
        tuple(_side(side, history, limits) for side, history in histories.items() if history),
    )


def _side(side: Side, history: Sequence[Seen], limits: Limits) -> SideTrend:
    found = {quantity: _quantity(history, quantity, limits) for quantity in Quantity}
    return SideTrend(
        side,
        len(history),
        {quantity: trend for quantity, trend in found.items() if trend.values},
    )


def _quantity(history: Sequence[Seen], quantity: Quantity, limits: Limits) -> QuantityTrend:
    values: list[TrendValue] = []
    points: list[TrendPoint] = []
    for place, seen in enumerate(history):
        point = seen.points.get(quantity)
        if point is None:
            continue
        jump = jump_to(history[:place], seen, quantity, limits)
        # What came before a jump was another wheel, or another shape of this one.
        points = [point] if jump is not None else [*points, point]
        values.append(_value(seen, quantity, None if jump is None else jump[0].change_mm))
    trend = fit_trend(points)
    if trend is None:
        return QuantityTrend(tuple(values), len(points), None, None, None)
    return QuantityTrend(tuple(values), trend.passes, trend.per_day, trend.per_pass, trend.scatter)


def _value(seen: Seen, quantity: Quantity, jump_mm: float | None) -> TrendValue:
    reading = seen.readings[quantity]
    return TrendValue(
        pass_id=seen.pass_id,
        at=seen.at,
        measurement_id=seen.measurement_id,
        calibration_id=seen.calibration_id,
        value=reading.value or 0.0,
        u95=reading.u95 or 0.0,
        status=reading.status,
        alarm=reading.alarm,
        jump=jump_mm,
    )
