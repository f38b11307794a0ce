"""Where on the target a point lies that is seen on a line with three known points."""

import numpy as np

from calib.arrays import FloatArray


def place_by_cross_ratio(
    known_mm: FloatArray, known_seen: FloatArray, point_seen: FloatArray
) -> FloatArray:
    r"""Return the place on a line of a point seen beside three known points of it.

    Parameters
    ----------
    known_mm
        Shape (..., 3), places A, B, C of three points along the line.
    known_seen
        Shape (..., 3), places a, b, c of their pictures along the line's picture, any unit.
    point_seen
        Shape (...,), place x of the fourth picture, the same unit.

    Returns
    -------
    place_mm
        X, shape (...,); infinite where the picture shows the line's vanishing point.

    Notes
    -----
    The cross-ratio is the same in the picture and on the line,

    .. math:: \frac{(a-c)(b-x)}{(b-c)(a-x)} = \frac{(A-C)(B-X)}{(B-C)(A-X)},

    solved for X without dividing by a distance that may be zero.

    Examples
    --------
    >>> seen = np.array([0.0, 1.0, 2.0])
    >>> place_by_cross_ratio(np.array([0.0, 10.0, 20.0]), seen, np.array(1.5)).item()
    15.0
    """
    a, b, c = np.moveaxis(known_seen, -1, 0)
    first, second, third = np.moveaxis(known_mm, -1, 0)
    x = point_seen
    over = (a - c) * (b - x) * (second - third)
    under = (b - c) * (a - x) * (first - third)
    with np.errstate(divide="ignore"):
        return np.asarray((second * under - first * over) / (under - over))
