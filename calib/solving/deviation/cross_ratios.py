"""Cross-ratios of four dots of a row or a column: the same on the target and in its picture."""

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.solving.observations import DotTable

_FOUR = 4


def fours_of(dots: DotTable) -> IntArray:
    """Choose four dots of every row and every column that shows four, spread over what is seen.

    Parameters
    ----------
    dots
        Of all views.

    Returns
    -------
    fours
        Shape (F, 4), places in the table, in order along their line.
    """
    place = dots.board_mm[:, :2]
    return np.array(
        [
            four
            for view in np.unique(dots.view)
            for across in (0, 1)
            for four in _spread_fours(np.flatnonzero(dots.view == view), place, across)
        ],
        dtype=np.int64,
    ).reshape(-1, _FOUR)


def _spread_fours(members: IntArray, place_mm: FloatArray, across: int) -> list[IntArray]:
    """Return fours on the lines of equal coordinate `across`, of one view."""
    found = []
    for line in np.unique(place_mm[members, across]):
        on_line = members[place_mm[members, across] == line]
        if len(on_line) >= _FOUR:
            ordered = on_line[np.argsort(place_mm[on_line, 1 - across])]
            found.append(ordered[np.linspace(0, len(ordered) - 1, _FOUR).round().astype(int)])
    return found


def cross_ratio(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Return the cross-ratios of fours of points, and what they owe to each point.

    Parameters
    ----------
    points
        Shape (F, 4, 2), nearly on lines, in order along them.

    Returns
    -------
    ratio
        Shape (F,), :math:`|AC| |BD| / (|BC| |AD|)`, 4/3 for even spacing.
    by_point
        Shape (F, 4, 2).

    Examples
    --------
    >>> even = np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]])
    >>> cross_ratio(even)[0].round(6).tolist()
    [1.333333]
    """
    ratio = np.ones(len(points))
    log_slope = np.zeros_like(points)
    for first, second, power in ((0, 2, 1), (1, 3, 1), (1, 2, -1), (0, 3, -1)):
        gap = points[:, second] - points[:, first]
        squared = (gap**2).sum(axis=1)
        ratio = ratio * np.sqrt(squared) ** power
        pull = power * gap / squared[:, None]
        log_slope[:, second] += pull
        log_slope[:, first] -= pull
    return ratio, ratio[:, None, None] * log_slope
