"""Which views' stripes lie on the light plane: a stripe may be false as a whole (stray light)."""

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.solving.joint.problem import Problem, Solution
from calib.solving.start import LEAST_STRIPE_POINTS

MOST_SURPRISE = 25.0
"""Chi square of an offset and a slope that a true stripe exceeds once in 300,000."""
# Median of chi square with two degrees of freedom.
_MEDIAN_SURPRISE = 1.386
# A stripe that alone determines its pose leaves nothing to compare it with; rounding must not
# make less than nothing of it.
_LEAST_REMAINDER = 1e-6
# Of points in one place, which have no slope.
_LEAST_SPREAD_PX = 1e-9
# A stripe that leaves less than this part of its view's dots believable has pulled the pose away.
_LEAST_DOTS_BELIEVED = 0.5


def believable_stripes(problem: Problem, solution: Solution) -> BoolArray:
    """Tell the views whose stripe lies on the sheet of the others, shape (M,).

    Each stripe is compared, by its offset and slope, with what everything else foretells: the
    dots of its view, and the sheet of the other views. What these leave open counts, else against
    noisy dots every stripe looked false. Where all stripes surprise more than they should, the
    common excess is taken as usual.
    """
    seen = problem.observations
    edges = np.searchsorted(seen.stripe.view, np.arange(seen.count + 1))
    dot_believed = solution.dots_mixture.believed(solution.dots.residual)
    surprise = np.full(seen.count, np.inf)
    dots = np.bincount(seen.dots.view, minlength=seen.count)
    pulled = np.bincount(seen.dots.view, dot_believed, seen.count) < _LEAST_DOTS_BELIEVED * dots
    for view, (first, last) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        if last - first >= LEAST_STRIPE_POINTS and not pulled[view]:
            surprise[view] = _surprise(problem, solution, view, np.arange(first, last))
    usual = np.median(surprise[np.isfinite(surprise)]) / _MEDIAN_SURPRISE
    return np.asarray(surprise <= MOST_SURPRISE * max(usual, 1.0))


def _surprise(problem: Problem, solution: Solution, view: int, rows: IntArray) -> float:
    r"""Return chi square of a stripe's offset and slope from what everything else foretells.

    Of a stripe that took part, with the variance V of its own offset and slope and the variance A
    that the solve leaves them, leaving it out would turn the residual m into
    :math:`V (V - A)^{-1} m` and A into :math:`V (V - A)^{-1} A`: the leverage formula.
    """
    # Single false points must not decide over the whole.
    rows = rows[problem.on_line[rows]]
    along = standardised(problem.observations.stripe.along_px[rows])
    to_line = np.stack([np.ones(len(rows)), along]) / len(rows)
    jacobian = to_line @ solution.stripe.jacobian[rows, 0]
    seen = to_line @ solution.stripe.residual[rows, 0]
    left = jacobian @ solution.covariance.of_view(view) @ jacobian.T
    mixture = solution.stripe_mixture
    weight = mixture.weights(solution.stripe.residual[rows]).sum()
    if problem.stripe_in[view] and weight >= 1.0:
        leverage, axes = np.linalg.eigh(left * (weight / mixture.variance))
        growth = axes @ np.diag(1.0 / np.maximum(1.0 - leverage, _LEAST_REMAINDER)) @ axes.T
        seen, left = growth @ seen, growth @ left
    # The noise of one point is allowed to the whole: a stripe may be a little off as a whole.
    expected = left + np.eye(2) * mixture.scale**2
    return float(seen @ np.linalg.solve(expected, seen))


def standardised(along_px: FloatArray) -> FloatArray:
    """Return places along a stripe, shape (N,), about their mean and over their spread.

    Beside a constant they are then an independent part of a residual: its slope.
    """
    return np.asarray((along_px - along_px.mean()) / max(along_px.std(), _LEAST_SPREAD_PX))
