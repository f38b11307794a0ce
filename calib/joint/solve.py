"""The robust maximum-likelihood solve: poses, and as wanted the light plane and the camera."""

from dataclasses import dataclass, field, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.errors import NotConverged
from calib.joint.mixture import Mixture
from calib.joint.normal_equations import ArrowCovariance, NormalEquations
from calib.joint.parameters import Estimate, Layout
from calib.joint.residuals import Linear, linearise_dots, linearise_stripe
from calib.lens import normalised_of
from calib.observations import Observations

_ITERATIONS = 100
# A step shorter than this many standard deviations (of all parameters together) is an arrival.
_ARRIVED = 1e-3
# Within this many standard deviations the residuals are noise rather than misfit.
_NEAR = 1.0
_LEAST_DAMPING, _FIRST_DAMPING, _MOST_DAMPING = 1e-12, 1e-4, 1e10


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is known of the global parameters beforehand.

    Attributes
    ----------
    camera
        Shape (9,), the expected intrinsics.
    information
        Inverse covariance of the free ones, in the order of the layout.
    """

    camera: FloatArray
    information: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What is to be solved.

    Attributes
    ----------
    observations, layout, prior
        The points; the free parameters; what is known of the camera beforehand, if anything.
    stripe_in
        Shape (M,), the views whose stripe takes part.
    """

    observations: Observations
    layout: Layout
    prior: Prior | None
    stripe_in: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The end of a solve.

    Attributes
    ----------
    estimate
        The answer.
    dots, stripe
        Residuals and Jacobian there.
    dots_mixture, stripe_mixture
        How the points scatter.
    covariance
        Of poses and global parameters, scaled by the scatter seen.
    cost, iterations
        Half the weighted sum of squares; steps taken.
    """

    estimate: Estimate
    dots: Linear
    stripe: Linear
    dots_mixture: Mixture
    stripe_mixture: Mixture
    covariance: ArrowCovariance
    cost: float
    iterations: int


@dataclass(slots=True, eq=False)
class _Climber:
    """A damped Gauss-Newton (Levenberg-Marquardt) walk with weights renewed at every step."""

    problem: Problem
    estimate: Estimate
    rays: FloatArray | None = None
    damping: float = _FIRST_DAMPING
    dots: Linear = field(init=False)
    stripe: Linear = field(init=False)

    def __post_init__(self) -> None:
        stripe = self.problem.observations.stripe
        self.rays = normalised_of(stripe.seen_px, self.estimate.camera)
        self.dots, self.stripe = self.linearise(self.estimate)

    def linearise(self, estimate: Estimate) -> tuple[Linear, Linear]:
        observations, layout = self.problem.observations, self.problem.layout
        stripe = linearise_stripe(observations.stripe, estimate, layout, self.rays)
        return linearise_dots(observations, estimate, layout), stripe

    def equations(
        self, dots: Linear, stripe: Linear, weights: tuple[FloatArray, FloatArray]
    ) -> tuple[NormalEquations, NormalEquations]:
        observations = self.problem.observations
        return (
            NormalEquations.of(dots, weights[0], observations.dots.view, observations.count),
            NormalEquations.of(stripe, weights[1], observations.stripe.view, observations.count),
        )
