"""A state of a solve with its residuals, and how far each point is believed there."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import FloatArray
from calib.solving.joint.mixture import Mixture, correlated_run
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import Estimate
from calib.solving.joint.problem import Problem
from calib.solving.joint.residuals import Linear, linearise_dots, linearise_stripe

# The scales have settled when a step changes them by less than this part.
_SCALE_SETTLED = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A state with its residuals and Jacobian."""

    estimate: Estimate
    dots: Linear
    stripe: Linear

    @classmethod
    def at(cls, problem: Problem, estimate: Estimate, rays: FloatArray) -> "Place":
        observations, layout = problem.observations, problem.layout
        # A wild trial step may divide by zero; its cost is then not finite and it is refused.
        with np.errstate(all="ignore"):
            return cls(
                estimate,
                linearise_dots(observations, estimate, layout),
                linearise_stripe(observations.stripe, estimate, layout, rays),
            )


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """How each kind of point scatters, and the weights that follow, fixed for one step."""

    dots: Mixture
    stripe: Mixture
    dots_weight: FloatArray
    stripe_weight: FloatArray

    @classmethod
    def of(cls, problem: Problem, place: Place, dots: Mixture, stripe: Mixture) -> "Belief":
        return cls(
            dots,
            stripe,
            dots.weights(place.dots.residual),
            np.where(problem.stripe_present, stripe.weights(place.stripe.residual), 0.0),
        )

    @classmethod
    def from_medians(cls, problem: Problem, place: Place) -> "Belief":
        """Judge from afar: all points pull a little."""
        return cls.of(problem, place, *cls._medians(problem, place))

    @classmethod
    def from_near(cls, problem: Problem, place: Place) -> "Belief":
        """Judge from near: gross errors stand out.

        A stripe is judged against its own line first. Its pose, by noisy dots alone, may put it
        far off the sheet as a whole, and it must be let in to pull the pose right.
        """
        dots, stripe = cls._medians(problem, place)
        dots = replace(dots, settled=True)
        return cls(
            dots,
            replace(stripe, settled=True),
            dots.weights(place.dots.residual),
            np.where(problem.stripe_present & problem.on_line, 1.0, 0.0),
        )

    @staticmethod
    def _medians(problem: Problem, place: Place) -> tuple[Mixture, Mixture]:
        seen, present = problem.observations, problem.stripe_present
        residual, sigma = place.stripe.residual[present], seen.stripe.sigma_px[present]
        return (
            Mixture.from_median(place.dots.residual, seen.dots.sigma_px),
            Mixture.from_median(residual, sigma),
        )

    def settled_at(self, problem: Problem, place: Place) -> "Belief":
        """Renew the mixtures by what this place leaves."""
        dots, stripe, total = self.equations(problem, place)
        covariance, present = total.covariance(), problem.stripe_present
        residual, weight = place.stripe.residual[present], self.stripe_weight[present]
        # Parameters follow a run of like residuals as one, so they spend a run for each freedom.
        spent = covariance.freedom_spent_on(stripe) * self.stripe.correlated
        return Belief.of(
            problem,
            place,
            self.dots.updated(
                place.dots.residual, self.dots_weight, covariance.freedom_spent_on(dots)
            ),
            self.stripe.updated(residual, weight, spent),
        )

    def held_at(self, problem: Problem, place: Place) -> "Belief":
        """Weigh the points at this place anew, by the same mixtures."""
        return Belief.of(problem, place, self.dots, self.stripe)

    def with_runs_at(self, problem: Problem, place: Place) -> "Belief":
        """Count stripe points that repeat their neighbours once."""
        table, present = problem.observations.stripe, problem.stripe_present
        run = correlated_run(
            place.stripe.residual[present, 0],
            self.stripe_weight[present],
            table.view[present],
            table.along_px[present],
        )
        return Belief.of(problem, place, self.dots, replace(self.stripe, correlated=run))

    def equations(
        self, problem: Problem, place: Place
    ) -> tuple[NormalEquations, NormalEquations, NormalEquations]:
        """Return the normal equations of dots, of stripe, and of everything with the prior."""
        seen = problem.observations
        dots = NormalEquations.of(
            place.dots, self.dots_weight / self.dots.variance, seen.dots.view, seen.count
        )
        stripe = NormalEquations.of(
            place.stripe, self.stripe_weight / self.stripe.variance, seen.stripe.view, seen.count
        )
        total = (dots + stripe).with_prior(*problem.prior_at(place.estimate))
        return dots, stripe, total

    def cost(self, problem: Problem, place: Place) -> float:
        """Return the cost of a place under these weights."""
        dots = place.dots.residual
        squares = np.einsum("ij,ij->i", dots, dots) @ self.dots_weight / self.dots.variance
        stripe = (place.stripe.residual**2)[:, 0] @ self.stripe_weight / self.stripe.variance
        information, gap = problem.prior_at(place.estimate)
        return float(squares + stripe + gap @ information @ gap) / 2.0

    def differs_from(self, other: "Belief") -> bool:
        """Tell whether the scales still move."""
        return any(
            abs(mine.scale - theirs.scale) > _SCALE_SETTLED * theirs.scale or not mine.settled
            for mine, theirs in ((self.dots, other.dots), (self.stripe, other.stripe))
        )
