"""How a wheel of the fleet stands: what is left to its limits, and until when."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from math import inf, isfinite

from measure import Alarm, Limit, Quantity, Side
from station.fleet.forecast import Forecast, forecast_of
from station.fleet.trends import FleetQuantity, FleetSide, FleetValue
from station.fleet.wear import Wear

StationLimits = Mapping[str, Mapping[Quantity, Limit]]
"""By station: what it judges its readings by."""
_GRAVITY = (Alarm.ALARM, Alarm.WARNING)


@dataclass(frozen=True, slots=True)
class QuantityStanding:
    """One quantity of a wheel; without a limit nothing is left or foretold.

    Attributes
    ----------
    limit
        Of the stations that measured it, the one that is met first.
    margin_mm
        What is left to the end that wear leads to; None where there is none.
    """

    quantity: Quantity
    last: FleetValue
    limit: Limit | None
    margin_mm: float | None
    wear: Wear | None
    forecast: Forecast | None

    @property
    def speed(self) -> float:
        """How fast it surely wears: the lower end of the rate's interval, mm a day."""
        if self.wear is None:
            return -inf
        rate = self.wear.per_day
        return (rate.value_mm if self.quantity.grows_with_wear else -rate.value_mm) - rate.u95_mm


@dataclass(frozen=True, slots=True)
class WheelStanding:
    """What a list of wheels says of one.

    Attributes
    ----------
    alarm
        The gravest of the last values.
    soonest, nearest, fastest
        The quantity that is at its limit first, by forecast, the one nearest to its limit, and
        the one that wears fastest; None where none is.
    """

    wheelset: str
    side: Side
    stations: tuple[str, ...]
    last_at: datetime
    alarm: Alarm
    soonest: QuantityStanding | None
    nearest: QuantityStanding | None
    fastest: QuantityStanding | None


def wheel_standing(wheelset: str, side: FleetSide, limits: StationLimits) -> WheelStanding:
    """Return how a wheel stands against the limits of the stations that measured it."""
    found = quantity_standings(side, limits)
    values = [value for each in side.quantities.values() for value in each.values]
    foretold = [each for each in found if _is_foretold(each.forecast)]
    limited = [each for each in found if each.margin_mm is not None]
    wearing = [each for each in limited or found if each.speed > 0.0]
    alarms = {each.last.alarm for each in found}
    return WheelStanding(
        wheelset,
        side.side,
        tuple(sorted({value.station for value in values})),
        max(value.at for value in values),
        next((alarm for alarm in _GRAVITY if alarm in alarms), Alarm.NONE),
        min(foretold, key=_expected, default=None),
        min(limited, key=_margin, default=None),
        max(wearing, key=_speed, default=None),
    )


def _is_foretold(forecast: Forecast | None) -> bool:
    return forecast is not None and (forecast.sure or forecast.margin_mm <= 0.0)


def quantity_standings(side: FleetSide, limits: StationLimits) -> list[QuantityStanding]:
    """Return how each quantity of a wheel stands."""
    return [_standing(quantity, found, limits) for quantity, found in side.quantities.items()]


def _standing(quantity: Quantity, found: FleetQuantity, limits: StationLimits) -> QuantityStanding:
    limit = _strictest(quantity, {value.station for value in found.values}, limits)
    end = None if limit is None else worn_end(quantity, limit)
    last, wear, grows = found.values[-1], found.wear, quantity.grows_with_wear
    if end is None:
        return QuantityStanding(quantity, last, limit, None, wear, None)
    if wear is None:
        margin = (end - last.value) if grows else (last.value - end)
        return QuantityStanding(quantity, last, limit, margin, None, None)
    forecast = forecast_of(wear, end, grows=grows)
    return QuantityStanding(quantity, last, limit, forecast.margin_mm, wear, forecast)


def worn_end(quantity: Quantity, limit: Limit) -> float | None:
    """Return the end of a limit that wear leads to, mm; None where it has none."""
    end = limit.high_mm if quantity.grows_with_wear else limit.low_mm
    return end if isfinite(end) else None


def _strictest(quantity: Quantity, stations: set[str], limits: StationLimits) -> Limit | None:
    found = [
        limits[name][quantity] for name in sorted(stations) if quantity in limits.get(name, {})
    ]
    if quantity.grows_with_wear:
        return min(found, key=lambda limit: limit.high_mm, default=None)
    return max(found, key=lambda limit: limit.low_mm, default=None)


def _expected(standing: QuantityStanding | None) -> float:
    if standing is None or standing.forecast is None:
        return inf
    return standing.forecast.expected_day


def _margin(standing: QuantityStanding | None) -> float:
    return inf if standing is None or standing.margin_mm is None else standing.margin_mm


def _speed(standing: QuantityStanding | None) -> float:
    return -inf if standing is None else standing.speed


def soonest_first(wheels: Sequence[WheelStanding]) -> list[WheelStanding]:
    """Return the wheels that are foretold to be at a limit, in the order of their days."""
    known = [each for each in wheels if each.soonest is not None]
    return sorted(known, key=lambda each: (_expected(each.soonest), each.wheelset, each.side))


def nearest_first(wheels: Sequence[WheelStanding]) -> list[WheelStanding]:
    """Return the wheels that have a limit, those with the least left first."""
    known = [each for each in wheels if each.nearest is not None]
    return sorted(known, key=lambda each: (_margin(each.nearest), each.wheelset, each.side))


def fastest_first(wheels: Sequence[WheelStanding]) -> list[WheelStanding]:
    """Return the wheels that surely wear, the fastest first."""
    known = [each for each in wheels if each.fastest is not None]
    return sorted(known, key=lambda each: (-_speed(each.fastest), each.wheelset, each.side))
