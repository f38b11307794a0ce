"""Whether stations read the same wheel alike: its wear, and what each station adds to it.

Pure: values in, offsets with their uncertainty out.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure import Rate

FloatArray = NDArray[np.float64]

_COVERAGE = 1.96
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
class StationOffset:
    """What a station reads more than the one that the others are held against.

    Attributes
    ----------
    values
        It rests on so many of this station's.
    u95_mm
        Half-width of the 95 % interval of `offset_mm` if both stations' u95 are right.
    agrees
        Whether zero lies in the interval.
    """

    station: str
    values: int
    offset_mm: float
    u95_mm: float

    @property
    def agrees(self) -> bool:
        return abs(self.offset_mm) <= self.u95_mm


@dataclass(frozen=True, slots=True)
class Agreement:
    """A wheel's wear over all stations, and the offsets of the others against `held_against`."""

    held_against: str
    per_day: Rate
    offsets: tuple[StationOffset, ...]


def station_agreement(values: Sequence[StationValue]) -> Agreement | None:
    r"""Fit one line of wear with an offset for each station to the values of one wheel.

    Parameters
    ----------
    values
        Of one quantity of one wheel, none from before it was turned or changed.

    Returns
    -------
    Agreement or None
        None of fewer than two stations.  The others are held against the one with the most values,
        of equals the first by name.

    Notes
    -----
    Weighted least squares of :math:`y_i = a + b t_i + o_{s(i)}`, weights :math:`1/\sigma_i^2`,
    :math:`\sigma_i = u_{95,i} / 1.96`, with :math:`b \sim N(0, \sigma_w^2)` known beforehand
    (`WEAR_SIGMA_MM_PER_DAY`).  A station's error is mostly that of its calibration, the same in all
    its values: it does not go down with their number.  The interval is therefore that of the
    offset of two values, one of each station, and of the wear between the stations' mean times:

    .. math:: u^2 = \overline{u_{95,s}^2} + \overline{u_{95,0}^2}
              + (1.96\,\sigma_b\,(\bar t_s - \bar t_0))^2

    It is too large where the errors are independent, never too small.
    """
    counted = Counter(each.station for each in values)
    if len(counted) < 2:
        return None
    first = min(counted, key=lambda name: (-counted[name], name))
    others = sorted(counted.keys() - {first})
    days = np.array([each.day for each in values])
    design = np.zeros((len(values), 2 + len(others)))
    design[:, 0] = 1.0
    design[:, 1] = days - days.mean()
    for row, each in enumerate(values):
        if each.station != first:
            design[row, 2 + others.index(each.station)] = 1.0
    sigma = np.array([each.u95_mm for each in values]) / _COVERAGE
    found, covariance = _solve(design, np.array([each.value_mm for each in values]), sigma)
    sigma_rate = float(covariance[1, 1] ** 0.5)
    offsets = tuple(
        StationOffset(
            name,
            counted[name],
            float(found[2 + place]),
            _interval(_of(values, name), _of(values, first), sigma_rate),
        )
        for place, name in enumerate(others)
    )
    return Agreement(first, Rate(float(found[1]), _COVERAGE * sigma_rate), offsets)


def _of(values: Sequence[StationValue], station: str) -> list[StationValue]:
    return [each for each in values if each.station == station]


def _solve(
    design: FloatArray, value: FloatArray, sigma: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the parameters (level, wear a day, offsets) and their covariance."""
    known = np.zeros(design.shape[1])
    known[1] = 1.0 / WEAR_SIGMA_MM_PER_DAY
    rows = np.vstack([design / sigma[:, None], known])
    information = rows.T @ rows
    covariance = np.linalg.inv(information)
    # From the mean: levels of a thousand mm (a diameter) would cost digits in the normal equations.
    level = float(value.mean())
    found = covariance @ (rows.T @ np.append((value - level) / sigma, 0.0))
    return found, covariance


def _interval(
    one: Sequence[StationValue], other: Sequence[StationValue], sigma_rate: float
) -> float:
    apart = _mean([each.day for each in one]) - _mean([each.day for each in other])
    own = _mean([each.u95_mm**2 for each in one]) + _mean([each.u95_mm**2 for each in other])
    return float((own + (_COVERAGE * sigma_rate * apart) ** 2) ** 0.5)


def _mean(numbers: Sequence[float]) -> float:
    return sum(numbers) / len(numbers)
