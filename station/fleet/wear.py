"""How fast a wheel wears, of values that several stations read, each with an error of its own.

Pure: values in, a rate and a level with their uncertainty out.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure import Rate

FloatArray = NDArray[np.float64]

COVERAGE = 1.96
"""From the standard deviation of a normal variable to its 95 % half-width."""
WEAR_SIGMA_MM_PER_DAY = 0.01
"""How fast a wheel may wear, before anything of it is seen: 95 % within 0.02 mm a day, either way.
Without it, two stations that saw a wheel once each would say nothing of how they agree."""


@dataclass(frozen=True, slots=True)
class StationValue:
    """A value of one wheel at one station; `day` counts from any moment."""

    station: str
    day: float
    value_mm: float
    u95_mm: float

    def __post_init__(self) -> None:
        finite = np.isfinite(self.day) and np.isfinite(self.value_mm)
        if not (finite and 0.0 < self.u95_mm < np.inf):
            raise ValueError(f"a value needs a time and a positive u95, got {self!r}")


@dataclass(frozen=True, slots=True)
class Wear:
    """The line of wear through a wheel's values, as one of its stations reads it.

    Attributes
    ----------
    held_against
        The station with the most values, of equals the first by name; the level is as it reads.
    from_day, day
        Of the first and the last value, of any station.
    level_mm, u95_mm
        The line there, and the u95 of a value of `held_against`: its error is mostly that of its
        calibration, which no number of passes makes smaller.
    per_day
        Rate of change.
    offsets_mm
        What each other station reads more.
    """

    held_against: str
    from_day: float
    day: float
    level_mm: float
    u95_mm: float
    per_day: Rate
    offsets_mm: dict[str, float]


def wear_of(values: Sequence[StationValue]) -> Wear | None:
    r"""Fit one line of wear with an offset for each further station to the values of one wheel.

    Parameters
    ----------
    values
        Of one quantity of one wheel, none from before it was turned or changed.

    Returns
    -------
    Wear or None
        None of fewer than two values.

    Notes
    -----
    Weighted least squares of :math:`y_i = a + b t_i + o_{s(i)}`, weights :math:`1/\sigma_i^2`,
    :math:`\sigma_i = u_{95,i} / 1.96`, with :math:`b \sim N(0, \sigma_w^2)` known beforehand
    (`WEAR_SIGMA_MM_PER_DAY`).  Where the values scatter more than their u95 says, the interval of
    the rate grows with the scatter: the wheel did not wear evenly.
    """
    if len(values) < 2:
        return None
    counted = Counter(each.station for each in values)
    first = min(counted, key=lambda name: (-counted[name], name))
    others = sorted(counted.keys() - {first})
    days = np.array([each.day for each in values])
    design = np.zeros((len(values), 2 + len(others)))
    design[:, 0] = 1.0
    design[:, 1] = days - days.mean()
    for row, each in enumerate(values):
        if each.station != first:
            design[row, 2 + others.index(each.station)] = 1.0
    sigma = np.array([each.u95_mm for each in values]) / COVERAGE
    value = np.array([each.value_mm for each in values])
    # From the mean: levels of a thousand mm (a diameter) would cost digits in the normal equations.
    mean = float(value.mean())
    found, sigma_rate = _solve(design, value - mean, sigma)
    last = float(days.max())
    return Wear(
        held_against=first,
        from_day=float(days.min()),
        day=last,
        level_mm=mean + float(found[0] + found[1] * (last - days.mean())),
        u95_mm=mean_u95(values, first),
        per_day=Rate(float(found[1]), COVERAGE * sigma_rate),
        offsets_mm=dict(zip(others, found[2:].tolist(), strict=True)),
    )


def mean_u95(values: Sequence[StationValue], station: str) -> float:
    """Return the root of the mean square of the u95 of a station's values, mm."""
    squares = [each.u95_mm**2 for each in values if each.station == station]
    return float((sum(squares) / len(squares)) ** 0.5)


def _solve(design: FloatArray, value: FloatArray, sigma: FloatArray) -> tuple[FloatArray, float]:
    """Return the parameters (level, rate, offsets) and the standard deviation of the rate."""
    known = np.zeros(design.shape[1])
    known[1] = 1.0 / WEAR_SIGMA_MM_PER_DAY
    rows = np.vstack([design / sigma[:, None], known])
    covariance = np.linalg.inv(rows.T @ rows)
    found = covariance @ (rows.T @ np.append(value / sigma, 0.0))
    spare = len(value) - design.shape[1] + 1  # what is known of the rate counts as a value
    left = (value - design @ found) / sigma
    scatter = float((left @ left / max(spare, 1)) ** 0.5)
    return np.asarray(found), float(covariance[1, 1] ** 0.5) * max(scatter, 1.0)
