"""Which views' stripes lie on the light plane: a stripe may be false as a whole (stray light)."""

import numpy as np

from calib.arrays import BoolArray, IntArray
from calib.joint.solve import Problem, Solution
from calib.lens import normalised_of
from calib.lines import fit_line_robustly
from calib.start import LEAST_STRIPE_POINTS

# A stripe lies on the sheet if its median point does within this many standard deviations.
_FITS = 3.0
# Chi square of an offset and a slope that a true stripe exceeds once in 300,000.
_MOST_SURPRISE = 25.0
# A stripe that leaves less than this part of its view's dots believable has pulled the pose away.
_LEAST_DOTS_BELIEVED = 0.5


def believable_stripes(problem: Problem, solution: Solution) -> BoolArray:
    """Tell the views whose stripe lies on the sheet of the others, shape (M,).

    A stripe that took part is judged by what is left of it, and by whether its pose still fits
    the dots. One that did not is judged by its offset and slope against what the dots leave open:
    against noisy dots even a true stripe looks far off until it is let in.
    """
    seen = problem.observations
    edges = np.searchsorted(seen.stripe.view, np.arange(seen.count + 1))
    dot_believed = solution.dots_mixture.believed(solution.dots.residual)
    believable = np.zeros(seen.count, dtype=bool)
    for view, (first, last) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        if last - first < LEAST_STRIPE_POINTS:
            continue
        rows = np.arange(first, last)
        if problem.stripe_in[view]:
            left = np.median(np.abs(solution.stripe.residual[rows, 0]))
            believable[view] = (
                left <= _FITS * solution.stripe_mixture.scale
                and dot_believed[seen.dots.view == view].mean() >= _LEAST_DOTS_BELIEVED
            )
        else:
            believable[view] = _surprise(problem, solution, view, rows) <= _MOST_SURPRISE
    return believable


def _surprise(problem: Problem, solution: Solution, view: int, rows: IntArray) -> float:
    """Return chi square of a left-out stripe's offset and slope from its prediction."""
    table = problem.observations.stripe
    # Single false points must not decide over the whole.
    rays = normalised_of(table.seen_px[rows], solution.estimate.camera)
    rows = rows[fit_line_robustly(rays)[1]]
    along = table.along_px[rows] - table.along_px[rows].mean()
    design = np.column_stack([np.ones(len(rows)), along / max(along.std(), 1e-9)])
    to_line = np.linalg.pinv(design)
    seen = to_line @ solution.stripe.residual[rows, 0]
    jacobian = to_line @ solution.stripe.jacobian[rows, 0]
    # The noise of a single point is allowed to the whole: a stripe may be a little off as a whole.
    expected = (
        jacobian @ solution.covariance.of_view(view) @ jacobian.T
        + np.eye(2) * solution.stripe_mixture.scale**2
    )
    return float(seen @ np.linalg.solve(expected, seen))
