"""A figure beside what is asked of it."""

from collections.abc import Sequence

import numpy as np

from station.tables import Value

Row = dict[str, Value]


def figure(what: str, value: Value, asked: str, *, holds: bool, spread: str = "") -> Row:
    """Return a row: what was measured, what came out, what is asked, and whether it holds."""
    return {"what": what, "figure": value, "spread": spread, "asked": asked, "holds": holds}


def none_of(what: str, count: int) -> Row:
    """Return the row of something that must not happen."""
    return figure(what, count, "0", holds=count == 0)


def below(what: str, values: Sequence[float], limit: float, unit: str) -> Row:
    """Return the row of values of which the largest must not exceed a limit: median and range."""
    low, middle, high = np.percentile(values, [0.0, 50.0, 100.0])
    return figure(
        f"{what}, {unit}",
        float(middle),
        f"<= {limit:g}",
        holds=bool(high <= limit),
        spread=f"{low:.3g} to {high:.3g}",
    )
