"""How a wheelset changes over its passes at all stations, and whether they read it alike."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import and_, select
from sqlalchemy.orm import Session

from measure import Alarm, Placing, Quantity, Side, Status
from station.errors import NotFound
from station.fleet.agreement import Agreement, station_agreement
from station.fleet.tables import FleetAxle, FleetPass, FleetWheel
from station.fleet.wear import StationValue, Wear, wear_of
from station.store import JsonObject

MOST_PASSES = 1000
"""Of a wheel: years of them."""
DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class FleetValue:
    """A value of one pass at one station; `jump_mm` where the station saw it jump there."""

    station: str
    pass_id: str
    at: datetime
    value: float
    u95: float
    status: Status
    alarm: Alarm
    reference: str
    jump_mm: float | None


@dataclass(frozen=True, slots=True)
class FleetQuantity:
    """The values of one quantity, the oldest first, and how the stations agree on it.

    Attributes
    ----------
    compared
        How many of them are since the last jump, and were read as the last one was: by the same
        status and reference.
    wear
        The line through these; its days count from 1970.  None of fewer than two.
    agreement
        Of the same values; None where they are of one station.
    """

    values: tuple[FleetValue, ...]
    compared: int
    wear: Wear | None
    agreement: Agreement | None


@dataclass(frozen=True, slots=True)
class FleetSide:
    """One wheel of a wheelset."""

    side: Side
    quantities: dict[Quantity, FleetQuantity]


@dataclass(frozen=True, slots=True)
class FleetTrend:
    """Both wheels of a wheelset."""

    wheelset: str
    stations: tuple[str, ...]
    sides: tuple[FleetSide, ...]


@dataclass(frozen=True, slots=True)
class _Found:
    """A wheel of a wheelset in one pass."""

    station: str
    pass_id: str
    at: datetime
    reference: str
    readings: JsonObject
    jumps: JsonObject


def fleet_trend(session: Session, wheelset: str, *, most: int = MOST_PASSES) -> FleetTrend:
    """Return how a wheelset changed over its last passes at all stations.

    Parameters
    ----------
    most
        Passes of each wheel, the newest; at most `MOST_PASSES`.

    Raises
    ------
    NotFound
        If no station has measured it at a place that is certain.
    """
    found = {side: _history(session, wheelset, side, min(most, MOST_PASSES)) for side in Side}
    if not any(found.values()):
        raise NotFound(
            f"wheelset {wheelset!r}: no station has measured it at a place that is certain; "
            "are consists told with the passes?"
        )
    stations = {each.station for history in found.values() for each in history}
    return FleetTrend(
        wheelset,
        tuple(sorted(stations)),
        tuple(_side(side, history) for side, history in found.items() if history),
    )


def measured_wheelsets(session: Session) -> list[str]:
    """Return the wheelsets that any station has measured at a place that is certain, by name."""
    query = (
        select(FleetAxle.wheelset)
        .where(FleetAxle.wheelset.is_not(None))
        .where(FleetAxle.wheelset_side.is_not(None))
        .where(FleetAxle.wheel_id.is_not(None))
        .where(FleetAxle.placing == Placing.CERTAIN.value)
        .distinct()
    )
    return sorted(name for name in session.scalars(query) if name is not None)


def _history(session: Session, wheelset: str, side: Side, most: int) -> Sequence[_Found]:
    epoch = "station", "epoch"
    of_pass = [getattr(FleetAxle, n) == getattr(FleetPass, n) for n in epoch]
    # The newest first and their readings after: readings of years would be read to be left out.
    newest = (
        select(
            FleetAxle.station,
            FleetAxle.epoch,
            FleetAxle.wheel_id,
            FleetAxle.jumps,
            FleetPass.id.label("pass_id"),
            FleetPass.opened_at,
        )
        .join(FleetPass, and_(*of_pass, FleetPass.id == FleetAxle.pass_id))
        .where(FleetAxle.wheelset == wheelset)
        .where(FleetAxle.wheelset_side == side.value)
        .where(FleetAxle.wheel_id.is_not(None))
        .where(FleetAxle.placing == Placing.CERTAIN.value)
        .where(~FleetPass.superseded)
        .order_by(FleetPass.opened_at.desc(), FleetAxle.station, FleetPass.id)
        .limit(most)
        .subquery()
    )
    of_wheel = [newest.c[n] == getattr(FleetWheel, n) for n in epoch]
    query = (
        select(
            newest.c.station,
            newest.c.pass_id,
            newest.c.opened_at,
            FleetWheel.reference,
            FleetWheel.readings,
            newest.c.jumps,
        )
        .join(FleetWheel, and_(*of_wheel, FleetWheel.id == newest.c.wheel_id))
        .order_by(newest.c.opened_at, newest.c.station.desc(), newest.c.pass_id.desc())
    )
    return [_Found(*row) for row in session.execute(query)]


def _side(side: Side, history: Sequence[_Found]) -> FleetSide:
    found = {quantity: _quantity(history, quantity) for quantity in Quantity}
    return FleetSide(side, {name: each for name, each in found.items() if each is not None})


def _quantity(history: Sequence[_Found], quantity: Quantity) -> FleetQuantity | None:
    values = [value for each in history if (value := _value(each, quantity)) is not None]
    if not values:
        return None
    compared = [
        StationValue(each.station, each.at.timestamp() / DAY_S, each.value, each.u95)
        for each in _comparable(values)
    ]
    return FleetQuantity(
        tuple(values), len(compared), wear_of(compared), station_agreement(compared)
    )


def _comparable(values: Sequence[FleetValue]) -> list[FleetValue]:
    """Return those since the last jump that were read in the way of the last."""
    last = values[-1]
    turned = max(
        (place for place, each in enumerate(values) if each.jump_mm is not None), default=0
    )
    return [
        each
        for each in values[turned:]
        if each.u95 > 0.0 and (each.status, each.reference) == (last.status, last.reference)
    ]


def _value(found: _Found, quantity: Quantity) -> FleetValue | None:
    reading = found.readings.get(quantity.value)
    if reading is None or reading["value"] is None:
        return None
    jump = found.jumps.get(quantity.value)
    return FleetValue(
        station=found.station,
        pass_id=found.pass_id,
        at=found.at,
        value=reading["value"],
        u95=reading["u95"],
        status=Status(reading["status"]),
        alarm=Alarm(reading["alarm"]),
        reference=found.reference,
        jump_mm=None if jump is None else jump["change"],
    )
