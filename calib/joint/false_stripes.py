"""Which views' stripes lie on the light plane: a stripe may be false as a whole (stray light)."""

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.joint.parameters import POSE_SIZE
from calib.joint.solve import Problem, Solution
from calib.start import LEAST_STRIPE_POINTS

# Chi square of an offset and a slope that a true stripe exceeds once in 300,000.
_MOST_SURPRISE = 25.0
# Median of chi square with two degrees of freedom.
_MEDIAN_SURPRISE = 1.386
# A stripe that leaves less than this part of its view's dots believable has pulled the pose away.
_LEAST_DOTS_BELIEVED = 0.5


def believable_stripes(problem: Problem, solution: Solution) -> BoolArray:
    """Tell the views whose stripe lies on the sheet of the others, shape (M,).

    Each stripe is compared, by its offset and slope, with what the dots of its view and the sheet
    foretell; what the dots leave open counts, else against noisy dots every stripe looked false.
    Where all stripes surprise more than they should, the common excess is taken as usual.
    """
    seen = problem.observations
    edges = np.searchsorted(seen.stripe.view, np.arange(seen.count + 1))
    dot_believed = solution.dots_mixture.believed(solution.dots.residual)
    surprise = np.full(seen.count, np.inf)
    for view, (first, last) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        pulled = dot_believed[seen.dots.view == view].mean() < _LEAST_DOTS_BELIEVED
        if last - first >= LEAST_STRIPE_POINTS and not pulled:
            surprise[view] = _surprise(problem, solution, view, np.arange(first, last))
    usual = np.median(surprise[np.isfinite(surprise)]) / _MEDIAN_SURPRISE
    return np.asarray(surprise <= _MOST_SURPRISE * max(usual, 1.0))


def _surprise(problem: Problem, solution: Solution, view: int, rows: IntArray) -> float:
    """Return chi square of a stripe's offset and slope from what dots and sheet foretell."""
    table = problem.observations.stripe
    # Single false points must not decide over the whole.
    rows = rows[problem.on_line[rows]]
    along = table.along_px[rows] - table.along_px[rows].mean()
    design = np.column_stack([np.ones(len(rows)), along / max(along.std(), 1e-9)])
    to_line = np.linalg.pinv(design)
    jacobian: FloatArray = to_line @ solution.stripe.jacobian[rows, 0]
    by_pose, by_shared = jacobian[:, :POSE_SIZE], jacobian[:, POSE_SIZE:]
    # The pose as the dots alone have it: the stripe may have pulled it.
    pose_covariance = np.linalg.inv(solution.dots_equations.views[view])
    pose_step = pose_covariance @ solution.dots_equations.views_side[view]
    seen = to_line @ solution.stripe.residual[rows, 0] - by_pose @ pose_step
    # The noise of one point is allowed to the whole: a stripe may be a little off as a whole.
    expected = (
        by_pose @ pose_covariance @ by_pose.T
        + by_shared @ solution.covariance.shared @ by_shared.T
        + np.eye(2) * solution.stripe_mixture.scale**2
    )
    return float(seen @ np.linalg.solve(expected, seen))
