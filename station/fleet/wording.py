"""The fleet in words that lines and pages share; moments are UTC."""

from datetime import datetime

from station.fleet.overview import StationState

NOTHING = "-"
_DAY_S = 86_400.0
_CLOCK_S = 5.0
"""Beyond it a clock is worth a word; the way to the fleet is part of what is seen."""


def remarks_on(state: StationState) -> list[str]:
    """Return what of a station wants somebody's attention."""
    clock = state.clock_ahead_s
    found = {
        f"calibration in doubt: {', '.join(state.doubtful)}": bool(state.doubtful),
        f"{state.alarms} alarms in its last pass": state.alarms > 0,
        f"its clock is {span(abs(clock))} {'ahead' if clock > 0 else 'behind'}": abs(clock)
        > _CLOCK_S,
        f"{state.refused} changes not taken": state.refused > 0,
        f"epoch {state.epochs} of its store": state.epochs > 1,
        "SEVERAL STORES SEND UNDER ITS NAME": state.rivals > 0,
    }
    return [text for text, holds in found.items() if holds]


def figure(value: float | None, digits: int) -> str:
    """Return a number with so many decimals, or that there is none."""
    return NOTHING if value is None else f"{value:.{digits}f}"


def moment(at: datetime | None) -> str:
    """Return a moment to the minute, or that there was none."""
    return NOTHING if at is None else f"{at:%Y-%m-%d %H:%M} UTC"


def span(seconds: float) -> str:
    """Return a duration in one unit.

    >>> span(90.0), span(7000.0), span(86_400.0), span(3e6)
    ('90 s', '117 min', '24 h', '35 days')
    """
    if seconds < 120.0:
        return f"{max(seconds, 0.0):.0f} s"
    if seconds < 7200.0:
        return f"{seconds / 60.0:.0f} min"
    if seconds < 2.0 * _DAY_S:
        return f"{seconds / 3600.0:.0f} h"
    return f"{seconds / _DAY_S:.0f} days"
