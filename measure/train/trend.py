"""How a wheel changes from pass to pass: its rate of wear, and jumps."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from calib import FloatArray
from measure.gauging.uncertainty import COVERAGE_FACTOR
from measure.limits import Limit

JUMP_COVERAGE = 1.5
"""A change that is none exceeds the u95 of the difference once in 20 times, 1.5 of it (2.9 sigma)
once in 300: a train has a thousand readings, and mostly the limit of a jump is far beyond both."""


@dataclass(frozen=True, slots=True)
class TrendPoint:
    """A value of one wheel in one pass; `day` counts from any moment."""

    day: float
    value_mm: float
    u95_mm: float

    def __post_init__(self) -> None:
        finite = math.isfinite(self.day) and math.isfinite(self.value_mm)
        if not (finite and 0.0 < self.u95_mm < math.inf):
            raise ValueError(f"a point needs a time, a value and a positive u95, got {self!r}")


@dataclass(frozen=True, slots=True)
class Rate:
    """Change in mm for each unit of time or pass, with the half-width of its 95 % interval."""

    value_mm: float
    u95_mm: float


@dataclass(frozen=True, slots=True)
class Trend:
    """The straight line through a wheel's values.

    Attributes
    ----------
    passes
        Values it rests on.
    per_day, per_pass
        Rates; None where all values are of one moment.
    scatter
        Root of the mean square of what the line leaves, in sigmas: 1 where the values scatter as
        their u95 says. None of two points, which every line meets.
    """

    passes: int
    per_day: Rate | None
    per_pass: Rate
    scatter: float | None


def fit_trend(points: Sequence[TrendPoint]) -> Trend | None:
    r"""Fit a straight line to the values of one wheel by weighted least squares.

    Parameters
    ----------
    points
        In the order of the passes.

    Returns
    -------
    Trend or None
        None of fewer than two points.

    Notes
    -----
    Weights are :math:`w_i = 1/\sigma_i^2` with :math:`\sigma_i = u_{95,i} / 1.96`; the slope is

    .. math:: b = \sum w_i (x_i - \bar x) y_i / S, \quad S = \sum w_i (x_i - \bar x)^2,

    and its variance :math:`1/S`, which is multiplied by :math:`\chi^2/(n-2)` where that is
    greater than 1: then the wheel did not wear evenly, or u95 is too small. In that case the
    interval is of Student's t with n - 2 degrees of freedom, else normal. Errors that all passes
    share (one calibration) shift every value alike and leave the slope; u95 is then too large,
    never too small.
    """
    if len(points) < 2:
        return None
    values = np.array([point.value_mm for point in points])
    sigma = np.array([point.u95_mm for point in points]) / COVERAGE_FACTOR
    days = np.array([point.day for point in points])
    per_pass, scatter = _slope(np.arange(len(points), dtype=np.float64), values, sigma)
    per_day, in_time = _slope(days, values, sigma) if np.ptp(days) > 0.0 else (None, None)
    return Trend(len(points), per_day, per_pass, in_time if per_day is not None else scatter)


def _slope(x: FloatArray, y: FloatArray, sigma: FloatArray) -> tuple[Rate, float | None]:
    weight = 1.0 / sigma**2
    centred = x - (weight @ x) / weight.sum()
    information = float(weight @ centred**2)
    slope = float(weight @ (centred * y)) / information
    spare = len(x) - 2
    factor = COVERAGE_FACTOR
    if spare == 0:
        return Rate(slope, factor / information**0.5), None
    left = y - (weight @ y) / weight.sum() - slope * centred
    scatter = float((weight @ left**2 / spare) ** 0.5)
    if scatter > 1.0:
        factor = float(stdtrit(spare, 0.975)) * scatter
    return Rate(slope, factor / information**0.5), scatter


@dataclass(frozen=True, slots=True)
class Jump:
    """A change from one pass to the next that wear does not explain."""

    change_mm: float
    u95_mm: float
    limit_mm: float


def jump_between(before: TrendPoint, after: TrendPoint, limit: Limit) -> Jump | None:
    """Return the jump from one pass to the next, or None where there is none.

    A jump is a change beyond `limit.jump_mm`, and beyond `JUMP_COVERAGE` times the u95 of the
    difference. It is a damaged wheel, a wheel turned anew, or one of another wheelset: which
    one, no reading tells.
    """
    change = after.value_mm - before.value_mm
    u95 = float(np.hypot(before.u95_mm, after.u95_mm))
    if abs(change) > limit.jump_mm and abs(change) > JUMP_COVERAGE * u95:
        return Jump(change, u95, limit.jump_mm)
    return None
