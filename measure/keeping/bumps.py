"""Dirt that stands on the steel: narrow rises that no wear makes."""

import numpy as np
from scipy.linalg import solveh_banded

from calib import BoolArray, FloatArray

_STEP_MM = 0.5
# Wear is broad: what is shorter than this is no part of it.
_SHORTEST_WEAR_MM = 12.0
# On face and throat of the flange wear leaves edges of some tenths.
_LEAST_MM, _LEAST_AT_EDGES_MM = 0.1, 0.3
_SIGMAS = 6.0
_WIDEST_MM = 8.0
_ROUNDS = 8
_SKIRT_MM = 1.0
_STIFFNESS = (_SHORTEST_WEAR_MM / (2.0 * np.pi * _STEP_MM)) ** 6
_DIFFERENCE = np.array([-1.0, 3.0, -3.0, 1.0])


def bumps(
    along_mm: FloatArray, outside_mm: FloatArray, sigma_mm: FloatArray, smooth: BoolArray
) -> BoolArray:
    r"""Tell which points lie on a rise that is too narrow for wear.

    Parameters
    ----------
    along_mm
        Shape (N,): place along the reference.
    outside_mm, sigma_mm
        Shape (N,): height over it, and its standard deviation.
    smooth
        Shape (N,): where wear leaves no edges. Elsewhere only a narrow rise over the reference
        is one.

    Returns
    -------
    on_bump
        Shape (N,), with a millimetre on either side, where a rise begins.

    Notes
    -----
    Heights are gathered every half millimetre and smoothed by a curve f that minimises
    :math:`\sum w (z - f)^2 + \lambda \sum (\Delta^3 f)^2` [1]_, which lets through what is longer
    than 12 mm. What stands out above has no weight in the next round: the curve settles on the
    steel under the dirt. What lies below, as a pit does, has less weight but is no dirt.

    References
    ----------
    .. [1] P. H. C. Eilers, "A perfect smoother", Analytical Chemistry 75(14), 2003.
    """
    if len(along_mm) == 0:
        return np.zeros(0, dtype=bool)
    place = np.floor((along_mm - along_mm.min()) / _STEP_MM).astype(np.int64)
    count = np.bincount(place)
    height = np.bincount(place, outside_mm) / np.maximum(count, 1)
    least = np.where(smooth, _LEAST_MM, _LEAST_AT_EDGES_MM)
    limit = np.bincount(place, np.maximum(_SIGMAS * sigma_mm, least)) / np.maximum(count, 1)
    told = np.bincount(place, smooth) > 0.0
    weight = told.astype(np.float64)
    for _ in range(_ROUNDS):
        rise = height - _smooth(height, weight)
        with np.errstate(divide="ignore", invalid="ignore"):
            trust = np.where(rise > 0.0, rise <= limit, np.minimum(1.0, (limit / -rise) ** 2))
        weight = np.where(told, trust, 0.0)
    # Between the told places the curve only bridges: there a rise is one over the reference.
    over = np.where(told, rise, np.minimum(rise, height))
    high = (over > limit) & (count > 0)
    run = np.cumsum(np.diff(high.astype(np.int64), prepend=0) != 0)
    narrow = np.bincount(run) * _STEP_MM <= _WIDEST_MM
    on_bump = high & (narrow | (np.bincount(run, high & told) > 0.0))[run]
    skirt = round(_SKIRT_MM / _STEP_MM)
    spread = np.convolve(on_bump, np.ones(2 * skirt + 1), mode="same") > 0.0
    return np.asarray(spread[place])


def _smooth(height_mm: FloatArray, weight: FloatArray) -> FloatArray:
    size = len(height_mm)
    if size <= len(_DIFFERENCE):
        return height_mm
    # The penalty's bands, from the diagonal out; at the ends fewer differences reach a node.
    bands = np.zeros((4, size))
    for k in range(4):
        for i in range(4 - k):
            bands[k, i : size - 3 + i] += _DIFFERENCE[i] * _DIFFERENCE[i + k]
    bands *= _STIFFNESS
    # A trace of weight everywhere keeps long gaps solvable.
    bands[0] += weight + 1e-6
    return np.asarray(solveh_banded(bands, weight * height_mm, lower=True))
