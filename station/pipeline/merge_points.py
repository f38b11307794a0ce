r"""The points of one pose out of several pictures: each from all that show it well.

Pictures of one pose err alike where the scene misleads them, as by the texture about a dot, and
apart where their own noise does. Of a point's variances :math:`\sigma_i^2` in the pictures a part
:math:`c` is common. It is at most the smallest, :math:`c = \kappa \min_i \sigma_i^2`, and what the
pictures differ by tells :math:`\kappa`, for they differ by nothing but what is their own:

.. math:: \mathrm{E}\, d_{ij}^2 = \sigma_i^2 + \sigma_j^2 - 2 c.

The mean of least variance, and that variance, are then

.. math:: \frac{\sum_i w_i x_i}{\sum_i w_i}, \quad c + \frac{1}{\sum_i w_i}, \quad
          w_i = \frac{1}{\sigma_i^2 - c}.

At :math:`\kappa = 1` that is the best of the pictures, at 0 the weighted mean of independent ones.
To choose the smallest sigma instead would choose the most underrated one as well.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from calib import Cause, FloatArray, IntArray, TargetPoints

_FEWEST_PAIRS = 12
"""Points seen in two pictures: fewer tell what is their own to worse than a quarter."""
_FREEDOM, _NORMAL_SCALE = 4.0, 0.6906
"""Of Student's t, whose far tails allow for points misled in one picture alone, and the square of
the scale at which it is the likeliest for normal differences of unit variance."""
_MOST_COMMON = 1.0 - 1e-6
"""Short of all, where the best would have an infinite weight."""
_SHARES = np.linspace(0.0, _MOST_COMMON, 51)


def merge_points(seen: Sequence[TargetPoints]) -> TargetPoints:
    """Return each point as the pictures of one pose show it together.

    Parameters
    ----------
    seen
        What each picture shows; at least one.

    Returns
    -------
    TargetPoints
        Every point that is in any of them, row by row. What nothing speaks against in some of
        them is their mean; what is doubtful in all is taken from where its sigma is the smallest.

    Raises
    ------
    ValueError
        If there is no picture.
    """
    if not seen:
        raise ValueError("no picture to take points from; give at least one")
    places, index = _places(seen)
    centre_px = np.zeros((*index.shape, 2))
    variance_px2 = np.full((*index.shape, 2), np.inf)
    clear = np.zeros(index.shape, dtype=bool)
    for picture, points in enumerate(seen):
        here = index[picture] >= 0
        of = index[picture, here]
        centre_px[picture, here] = points.centre_px[of]
        variance_px2[picture, here] = points.sigma_px[of] ** 2
        clear[picture, here] = np.array([one is Cause.NONE for one in points.cause])[of]
    best = np.argmin(variance_px2.sum(axis=2), axis=0)
    doubtful = np.flatnonzero(~clear.any(axis=0))
    clear[best[doubtful], doubtful] = True
    cause = [Cause.NONE] * len(places)
    for i in doubtful:
        cause[i] = seen[best[i]].cause[index[best[i], i]]
    mean_px, sigma_px = _means(centre_px, np.where(clear[:, :, None], variance_px2, np.inf))
    return TargetPoints(places[:, 0], places[:, 1], mean_px, sigma_px, tuple(cause))


def _places(seen: Sequence[TargetPoints]) -> tuple[IntArray, IntArray]:
    """Return (row, col) of all points, shape (N, 2), and their index in each picture, (P, N).

    The index is -1 where a picture does not show a point.
    """
    of_each = [np.column_stack([points.row, points.col]) for points in seen]
    places, number = np.unique(np.concatenate(of_each), axis=0, return_inverse=True)
    index = np.full((len(seen), len(places)), -1)
    ends = np.cumsum([len(points) for points in seen])
    for picture, mine in enumerate(np.split(number.ravel(), ends[:-1])):
        index[picture, mine] = np.arange(len(mine))
    return places, index


def _means(centre_px: FloatArray, variance_px2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return means over pictures and their sigmas, shapes (N, 2), of shapes (P, N, 2).

    The variance is infinite where a picture is not to be used; one of each point is not.
    """
    least = variance_px2.min(axis=0)
    common = _common_share(centre_px, variance_px2, least) * least
    weight = 1.0 / (variance_px2 - common)
    total = weight.sum(axis=0)
    return (weight * centre_px).sum(axis=0) / total, np.sqrt(common + 1.0 / total)


def _common_share(centre_px: FloatArray, variance_px2: FloatArray, least_px2: FloatArray) -> float:
    """Return kappa: the share of the least variance that is common to the pictures.

    Where too few points are in two pictures that is all but 1, which takes each from its best.
    """
    square, both, least = [np.empty(0)], [np.empty(0)], [np.empty(0)]
    for one, other in combinations(range(len(centre_px)), 2):
        of_both = variance_px2[one] + variance_px2[other]
        shown = np.isfinite(of_both)
        square.append((centre_px[one] - centre_px[other])[shown] ** 2)
        both.append(of_both[shown])
        least.append(least_px2[shown])
    d2, v, m = np.concatenate(square), np.concatenate(both), np.concatenate(least)
    if len(d2) < 2 * _FEWEST_PAIRS:
        return _MOST_COMMON
    # The most likely share: a pair that tells little of it, one picture far worse, says little.
    own = v - 2.0 * _SHARES[:, None] * m
    far = np.log1p(d2 / (_FREEDOM * _NORMAL_SCALE * own))
    unlikely = (np.log(own) + (_FREEDOM + 1.0) * far).sum(axis=1)
    return float(_SHARES[np.argmin(unlikely)])
