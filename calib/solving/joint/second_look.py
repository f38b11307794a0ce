r"""A second look at stripes that seem false where the tilt of their board is hardly known.

At large noise of the dots a small board far away may tilt by degrees, and a degree is not small:
what its dots foretell of the stripe is then no longer linear, and a true stripe may look a hundred
times too surprising. There the question is put in full: solved with the stripe and without it, by
how much more do all points surprise? For a true stripe that is a chi square of its offset and slope
(a likelihood ratio, whose linear part is what `believable_stripes` computes).
"""

from dataclasses import replace

import numpy as np

from calib.arrays import BoolArray
from calib.errors import NotConverged
from calib.solving.joint.false_stripes import MOST_SURPRISE, standardised
from calib.solving.joint.problem import Problem, Solution
from calib.solving.joint.solve import solve
from calib.solving.start import LEAST_STRIPE_POINTS

# Of the pose's rotation, rad (half a degree): what is better known is linear enough.
_LOOSE_TILT = 0.01
_FEWEST_STRIPES = 2


def acquitted(problem: Problem, solution: Solution, doubted: BoolArray) -> BoolArray:
    """Tell which of the views doubted have a true stripe after all, shape (M,).

    Parameters
    ----------
    problem, solution
        What was solved last, and how it ended.
    doubted
        Shape (M,), views whose stripe seems false.
    """
    count = np.bincount(problem.observations.stripe.view, minlength=len(doubted))
    tilt = np.sqrt(np.einsum("vii->vi", solution.covariance.views)[:, :3].max(axis=1))
    looked_at = doubted & (count >= LEAST_STRIPE_POINTS) & (tilt > _LOOSE_TILT)
    true = np.zeros(len(doubted), dtype=bool)
    without = replace(problem, stripe_in=problem.stripe_in & ~doubted)
    if not looked_at.any() or without.stripe_in.sum() < _FEWEST_STRIPES:
        return true
    try:
        base = solve(without, solution.estimate, near=True)
    except NotConverged:
        return true
    for view in np.flatnonzero(looked_at):
        true[view] = _surprise_of(without, base, int(view)) <= MOST_SURPRISE
    return true


def _surprise_of(without: Problem, base: Solution, view: int) -> float:
    """Return how much more everything surprises with the stripe of a view than without it."""
    added = np.arange(len(without.stripe_in)) == view
    try:
        full = solve(
            replace(without, stripe_in=without.stripe_in | added), base.estimate, near=True
        )
    except NotConverged:
        return np.inf
    dots, stripe, others = base.dots_mixture, base.stripe_mixture, without.stripe_present
    more_dots = dots.surprise(full.dots.residual) - dots.surprise(base.dots.residual)
    more_others = stripe.surprise(full.stripe.residual) - stripe.surprise(base.stripe.residual)
    own = without.on_line & (without.observations.stripe.view == view)
    along = standardised(without.observations.stripe.along_px[own])
    residual = full.stripe.residual[own, 0]
    offset_and_slope = (residual.sum() ** 2 + (residual @ along) ** 2) / len(residual)
    total = more_dots.sum() + more_others[others].sum() + offset_and_slope / stripe.variance
    return float(total)
