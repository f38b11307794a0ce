"""What blur does to a stripe that bends: it is drawn to the inside of the bend."""

import numpy as np
from scipy.spatial import cKDTree

from calib import FloatArray, StripePoints, kernel_of

_NEIGHBOURS = 21
_REACH_PX = 20.0
_SAME_WAY = 0.8
_MIN_POINTS = 40
_ROUNDS = 5


def bend_px(stripe: StripePoints) -> FloatArray:
    r"""Return how far bends have drawn the stripe's centres along their normals, px.

    Parameters
    ----------
    stripe
        As `calib.locate_stripe` gives it, in any order.

    Returns
    -------
    drawn_px
        Shape (N,): to be taken off; zero on the straight stripes of flat targets.

    Notes
    -----
    Everything that spreads light along the stripe takes the chord for the arc: a spread of
    variance :math:`\tau^2` along a stripe of curvature :math:`\kappa` moves its ridge inwards by

    .. math:: \kappa \tau^2 / 2 .

    The lens spreads alike in all directions, the thickness of the laser sheet along one
    direction of the picture, the same for the whole wheel. Both widen the profile across the
    stripe, so the variance of the profile is :math:`n^T W n` with one matrix W for the picture,
    found from stripes that run different ways; along the stripe it is :math:`t^T W t`. The
    detector's own kernel adds its variance.
    """
    if len(stripe) < _MIN_POINTS:
        return np.zeros(len(stripe))
    along = _spread_along(stripe) + kernel_of(stripe.width_px) ** 2
    return _curvature(stripe) * along / 2.0


def _curvature(stripe: StripePoints) -> FloatArray:
    """Return the curvature at each point, 1/px, positive where the stripe bends to its normal."""
    count = min(_NEIGHBOURS, len(stripe))
    distance, near = cKDTree(stripe.centre_px).query(stripe.centre_px, k=count)
    normal_u, normal_v = stripe.normal.T
    step_u, step_v = (column[near] - column[:, None] for column in stripe.centre_px.T)
    s = step_v * normal_u[:, None] - step_u * normal_v[:, None]
    f = step_u * normal_u[:, None] + step_v * normal_v[:, None]
    turned = normal_u[near] * normal_u[:, None] + normal_v[near] * normal_v[:, None]
    weight = ((np.abs(turned) > _SAME_WAY) & (distance < _REACH_PX)).astype(np.float64)
    design = np.stack([weight, weight * s, weight * s * s], axis=1)
    powers = np.stack([np.ones_like(s), s, s * s, f], axis=2)
    normal, moments = np.split(design @ powers, [3], axis=2)
    # A point by itself bends nothing: a trace of stiffness keeps its equations solvable.
    normal = normal + np.eye(3) * [1e-9, 1e-6, 1e-3]
    return np.asarray(2.0 * np.linalg.solve(normal, moments)[:, 2, 0])


def _spread_along(stripe: StripePoints) -> FloatArray:
    """Return the variance that the picture spreads along the stripe at each point, px²."""
    u, v = stripe.normal.T
    design = np.column_stack([u * u, 2.0 * u * v, v * v])
    variance = stripe.width_px**2
    typical = float(np.median(variance))
    # Where all runs one way, W is told across the stripe only; along it the same is assumed.
    weak = 1e-2 * len(stripe) * np.diag([1.0, 2.0, 1.0])
    prior = weak @ [typical, 0.0, typical]
    weight = np.ones(len(stripe))
    for _ in range(_ROUNDS):
        weighted = design.T * weight
        matrix = np.linalg.solve(weighted @ design + weak, weighted @ variance + prior)
        rest = np.abs(variance - design @ matrix)
        weight = 1.0 / np.maximum(rest, 0.1 * typical)
        weight /= weight.max()
    along = matrix[0] * v * v - 2.0 * matrix[1] * u * v + matrix[2] * u * u
    return np.asarray(np.clip(along, 0.0, 4.0 * typical))
