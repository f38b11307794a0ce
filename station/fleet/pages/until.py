"""When a wheel is at its limit, in words."""

from datetime import UTC, datetime, timedelta

from station.fleet.forecast import Forecast
from station.fleet.pages.parts import UNKNOWN, mm
from station.fleet.standing import QuantityStanding, worn_end
from station.fleet.wear import Wear

_BEGAN = datetime(1970, 1, 1, tzinfo=UTC)
_HORIZON_DAYS = 20 * 365.25
_MONTH_DAYS = 30.0


def date_of(day: float) -> str:
    """Return the date of a day since 1970.

    >>> date_of(20_000.5)
    '2024-10-04'
    """
    return f"{_BEGAN + timedelta(days=day):%Y-%m-%d}"


def expected(standing: QuantityStanding) -> str:
    """Return the date at which the line of wear meets the limit, as far as it is known."""
    found, wear = standing.forecast, standing.wear
    if found is None or wear is None:
        return UNKNOWN
    if found.margin_mm <= 0.0:
        return "beyond it"
    if found.sure and found.expected_day - wear.day < _HORIZON_DAYS:
        return date_of(found.expected_day)
    return _not_before(found, wear)


def interval(standing: QuantityStanding) -> str:
    """Return the 95 % interval of that date."""
    found, wear = standing.forecast, standing.wear
    if found is None or wear is None or found.margin_mm <= 0.0 or not found.sure:
        return UNKNOWN
    if found.latest_day - wear.day >= _HORIZON_DAYS:
        return f"from {date_of(min(found.earliest_day, wear.day + _HORIZON_DAYS))} on"
    return f"{date_of(found.earliest_day)} to {date_of(found.latest_day)}"


def _not_before(found: Forecast, wear: Wear) -> str:
    if found.earliest_day - wear.day >= _HORIZON_DAYS:
        return "not within 20 years"
    return f"not before {date_of(found.earliest_day)}"


def rate_and_u95(wear: Wear | None) -> tuple[str, str]:
    """Return how fast it wears in a month of 30 days, and how surely."""
    if wear is None:
        return UNKNOWN, UNKNOWN
    value, u95 = wear.per_day.value_mm * _MONTH_DAYS, wear.per_day.u95_mm * _MONTH_DAYS
    return mm(value, 3, signed=True), f"\N{PLUS-MINUS SIGN} {mm(u95, 3)}"


def sentence(standing: QuantityStanding) -> str:
    """Return what a planner wants to know of a quantity, in a line."""
    if standing.wear is None:
        said = "One value tells no wear."
    else:
        rate, u95 = rate_and_u95(standing.wear)
        said = f"{rate} {u95} in 30 days, as {standing.wear.held_against} reads it."
    end = None if standing.limit is None else worn_end(standing.quantity, standing.limit)
    if end is None or standing.margin_mm is None:
        return said
    if standing.margin_mm <= 0.0:
        return f"{said} {mm(-standing.margin_mm)} beyond its limit of {end:g} mm."
    left = f"{said} {mm(standing.margin_mm)} left to {end:g} mm"
    if standing.forecast is None:
        return f"{left}."
    when = expected(standing)
    held = f" ({interval(standing)})" if standing.forecast.sure and when[0].isdigit() else ""
    return f"{left}: {when}{held}."
