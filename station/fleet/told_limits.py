"""The limits of a station as the fleet keeps them."""

from math import inf, isfinite

from measure import Limit, Limits, Quantity
from station.store import JsonObject


def limits_as_told(limits: Limits) -> JsonObject:
    """Return limits as JSON; an end that there is not is None.

    >>> limits_as_told(Limits("ours", {Quantity.HOLLOW_DEPTH: Limit(high_mm=2.0)}))["of"]
    {'hollow_depth': {'low': None, 'high': 2.0, 'warn_within': 0.5}}
    """
    return {
        "regime": limits.regime,
        "of": {
            quantity.value: {
                "low": _end(limit.low_mm),
                "high": _end(limit.high_mm),
                "warn_within": limit.warn_within_mm,
            }
            for quantity, limit in limits.of.items()
        },
    }


def limits_told(told: JsonObject | None) -> dict[Quantity, Limit]:
    """Return the limits of a station; none of one that has told none, of an earlier version.

    Quantities of a later version are left out.
    """
    known = {quantity.value for quantity in Quantity}
    found = {} if told is None else told["of"]
    return {
        Quantity(name): Limit(
            low_mm=-inf if each["low"] is None else each["low"],
            high_mm=inf if each["high"] is None else each["high"],
            warn_within_mm=each["warn_within"],
        )
        for name, each in found.items()
        if name in known
    }


def _end(value_mm: float) -> float | None:
    return value_mm if isfinite(value_mm) else None
