"""Straight lines and planes through points, some of which may be false."""

import numpy as np

from calib.arrays import BoolArray, FloatArray

# Of 100 pairs at least one is clean with a chance of 1 - 3e-13 at 50 % false points.
_SAMPLES = 100
# So many points, evenly taken, know the median distance of all to a tenth: enough to choose by.
_JUDGES = 200
# Points within this many robust standard deviations of the best sample's line are kept.
_KEEP = 4.0


def fit_line_robustly(points: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Fit a line to points of which up to a half may be false.

    The line through two points with the smallest median distance picks the points that agree;
    those are fitted by total least squares. The same points always give the same line.

    Parameters
    ----------
    points
        Shape (N, 2), N >= 2, not all the same.

    Returns
    -------
    line
        (l, m, n) with ``l x + m y + n = 0`` and l^2 + m^2 = 1, shape (3,).
    agreeing
        Shape (N,), the points it was fitted to.
    """
    pairs = np.random.default_rng(0).integers(0, len(points), (_SAMPLES, 2))
    ahead = points[pairs[:, 1]] - points[pairs[:, 0]]
    length = np.linalg.norm(ahead, axis=1)
    pairs, ahead = pairs[length > 0.0], ahead[length > 0.0] / length[length > 0.0, None]
    if len(pairs) == 0:
        return fit_line(points), np.ones(len(points), dtype=bool)
    across = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    offsets = np.einsum("ij,ij->i", across, points[pairs[:, 0]])
    judges = points[:: max(len(points) // _JUDGES, 1)]
    chosen = np.argmin(np.median(np.abs(judges @ across.T - offsets), axis=0))
    best = np.abs(points @ across[chosen] - offsets[chosen])
    # A normal variable has the median size 0.6745 sigma; rounding must not sort points out.
    agreeing = best <= _KEEP * (np.median(best) / 0.6745) + 1e-12
    return fit_line(points[agreeing]), agreeing


def fit_line(points: FloatArray) -> FloatArray:
    """Fit a line to points, shape (N, 2), by total least squares; form as `fit_line_robustly`."""
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    across = np.array([-axes[0, 1], axes[0, 0]])
    return np.append(across, -across @ centre)


def fit_plane(points_mm: FloatArray) -> FloatArray:
    """Fit a plane to points, shape (N, 3) with N >= 3, by total least squares.

    Returns
    -------
    coefficients
        (a, b, c, d) with a unit normal, shape (4,).
    """
    centre = points_mm.mean(axis=0)
    _, _, axes = np.linalg.svd(points_mm - centre, full_matrices=False)
    return np.append(axes[2], -axes[2] @ centre)
