r"""Which of the lens's further terms the views ask for: p1 and p2, then k3.

A term that the lens does not have costs accuracy where it is free. So one joins only where chi
square falls by more than chance makes it fall, and chance is not that of independent points alone:
a place of the target errs alike in all views, by the texture about a dot or a dot a little off its
place. Such errors agree over the views as the lens's do, the more clearly the less noise is left.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.camera import PARAMETERS
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import POSE_SIZE, Layout
from calib.solving.joint.problem import Problem, Solution
from calib.solving.joint.residuals import Linear, linearise_dots
from calib.solving.joint.solve import solve

_EXTRAS = (("p1", "p2"), ("k3",))
"""In the order in which they are tried."""


def with_supported_terms(problem: Problem, solution: Solution) -> tuple[Problem, Solution]:
    """Free the terms that the views ask for, and solve again with them.

    Parameters
    ----------
    problem, solution
        Of poses and camera by the target's points alone, the further terms held.
    """
    for names in _EXTRAS:
        extra = [PARAMETERS.index(name) for name in names]
        layout = Layout(tuple(sorted({*problem.layout.camera, *extra})), plane=False)
        if _is_supported(problem, solution, layout, extra):
            problem = replace(problem, layout=layout)
            solution = solve(problem, solution.estimate, near=True)
    return problem, solution


def _is_supported(
    problem: Problem, solution: Solution, layout: Layout, extra: Sequence[int]
) -> bool:
    """Tell whether further free parameters lower the cost by more than chance does.

    The fall of chi square that one Gauss-Newton step foretells (a score test), over the design
    effect, must exceed the price of the Bayesian information criterion, the logarithm of the
    count per parameter.
    """
    dots, mixture = problem.observations.dots, solution.dots_mixture
    weights = mixture.weights(solution.dots.residual) / mixture.variance
    linear = linearise_dots(problem.observations, solution.estimate, layout)
    equations = NormalEquations.of(linear, weights, dots.view, problem.observations.count)
    price = len(extra) * np.log(2.0 * len(dots))
    fall = equations.step(damping=0.0)[2]
    if not fall > price:
        return False
    place = np.unique(dots.board_mm, axis=0, return_inverse=True)[1].ravel()
    new = [layout.camera.index(parameter) for parameter in extra]
    return bool(fall > price * _design_effect(linear, weights, equations, dots.view, place, new))


def _design_effect(
    linear: Linear,
    weights: FloatArray,
    equations: NormalEquations,
    view: IntArray,
    place: IntArray,
    terms: Sequence[int],
) -> float:
    r"""Return how many times the variance of some terms is what independent points make it.

    Parameters
    ----------
    linear, weights, equations
        Of N points, all terms free.
    view, place
        Shape (N,): whose errors may agree is of one place.
    terms
        Indices into the global block.

    Returns
    -------
    effect
        The mean over the terms, at least 1.

    Notes
    -----
    What the points of a place do to the terms together, with what a step leaves of their
    residuals, is squared and summed over the places [1]_: a covariance V that holds whatever
    agrees within a place. With C that of independent points the effect is
    :math:`\mathrm{tr}(C^{-1} V) / k`; a chi square of k terms is corrected by it to first
    order [2]_.

    References
    ----------
    .. [1] K.-Y. Liang and S. L. Zeger, "Longitudinal data analysis using generalized linear
       models", Biometrika 73(1), 1986.
    .. [2] J. N. K. Rao and A. J. Scott, "The analysis of categorical data from complex sample
       surveys", Journal of the American Statistical Association 76(374), 1981.
    """
    shared_step, pose_steps, _ = equations.step(damping=0.0)
    step = np.column_stack([pose_steps, np.tile(shared_step, (len(pose_steps), 1))])
    left = linear.residual - np.einsum("nij,nj->ni", linear.jacobian, step[view])
    pull = np.einsum("nij,ni,n->nj", linear.jacobian, left, weights)
    covariance = equations.covariance()
    moved = pull[:, POSE_SIZE:] @ covariance.shared[:, terms]
    moved += np.einsum("nj,njk->nk", pull[:, :POSE_SIZE], covariance.cross[view][:, :, terms])
    by_place = np.zeros((place.max() + 1, len(terms)))
    np.add.at(by_place, place, moved)
    of_independent = covariance.shared[np.ix_(terms, terms)]
    effect = np.trace(np.linalg.solve(of_independent, by_place.T @ by_place)) / len(terms)
    return max(1.0, float(effect))
