"""The robust maximum-likelihood solve: poses, and as wanted the light plane and the camera."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.errors import NotConverged
from calib.joint.mixture import Mixture, correlated_run
from calib.joint.normal_equations import ArrowCovariance, NormalEquations
from calib.joint.parameters import POSE_SIZE, Estimate, Layout
from calib.joint.residuals import Linear, linearise_dots, linearise_stripe
from calib.lens import normalised_of
from calib.observations import Observations

# Where a few exact points sway many, belief and answer settle slowly: 108 steps were seen.
_ITERATIONS = 500
# A step shorter than this many standard deviations (of all parameters together) is an arrival.
_ARRIVED = 1e-3
# The scales have settled when a step changes them by less than this part.
_SCALE_SETTLED = 1e-3
# A step of less than this many standard deviations a parameter: what is left is noise, not misfit.
_NEAR = 0.5
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
    on_line
        Shape (N,), the stripe points that lie on the line of their own view's stripe.
    """

    observations: Observations
    layout: Layout
    prior: Prior | None
    stripe_in: BoolArray
    on_line: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The end of a solve that converged.

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
    cost
        Half the weighted sum of squares.
    iterations
        Steps taken.
    """

    estimate: Estimate
    dots: Linear
    stripe: Linear
    dots_mixture: Mixture
    stripe_mixture: Mixture
    covariance: ArrowCovariance
    cost: float
    iterations: int


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """A state with its residuals and Jacobian."""

    estimate: Estimate
    dots: Linear
    stripe: Linear

    @classmethod
    def at(cls, problem: Problem, estimate: Estimate, rays: FloatArray) -> "_Place":
        observations, layout = problem.observations, problem.layout
        # A wild trial step may divide by zero; its cost is then not finite and it is refused.
        with np.errstate(all="ignore"):
            return cls(
                estimate,
                linearise_dots(observations, estimate, layout),
                linearise_stripe(observations.stripe, estimate, layout, rays),
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Belief:
    """How each kind of point scatters, and the weights that follow, fixed for one step."""

    dots: Mixture
    stripe: Mixture
    dots_weight: FloatArray
    stripe_weight: FloatArray

    @classmethod
    def of(cls, problem: Problem, place: _Place, dots: Mixture, stripe: Mixture) -> "_Belief":
        present = problem.stripe_in[problem.observations.stripe.view]
        return cls(
            dots,
            stripe,
            dots.weights(place.dots.residual),
            np.where(present, stripe.weights(place.stripe.residual), 0.0),
        )

    @classmethod
    def from_medians(cls, problem: Problem, place: _Place) -> "_Belief":
        """Judge from afar: all points pull a little."""
        return cls.of(problem, place, *cls._medians(problem, place))

    @classmethod
    def from_near(cls, problem: Problem, place: _Place) -> "_Belief":
        """Judge from near: gross errors stand out.

        A stripe is judged against its own line first. Its pose, by noisy dots alone, may put it
        far off the sheet as a whole, and it must be let in to pull the pose right.
        """
        dots, stripe = cls._medians(problem, place)
        present = problem.stripe_in[problem.observations.stripe.view]
        dots = replace(dots, settled=True)
        return cls(
            dots,
            replace(stripe, settled=True),
            dots.weights(place.dots.residual),
            np.where(present & problem.on_line, 1.0, 0.0),
        )

    @staticmethod
    def _medians(problem: Problem, place: _Place) -> tuple[Mixture, Mixture]:
        seen = problem.observations
        present = problem.stripe_in[seen.stripe.view]
        residual, sigma = place.stripe.residual[present], seen.stripe.sigma_px[present]
        return (
            Mixture.from_median(place.dots.residual, seen.dots.sigma_px),
            Mixture.from_median(residual, sigma),
        )

    def settled_at(self, problem: Problem, place: _Place) -> "_Belief":
        """Renew the mixtures by what this place leaves."""
        dots, stripe, total = self.equations(problem, place)
        covariance = _covariance(total)
        present = problem.stripe_in[problem.observations.stripe.view]
        residual, weight = place.stripe.residual[present], self.stripe_weight[present]
        # Parameters follow a run of like residuals as one, so they spend a run for each freedom.
        spent = covariance.freedom_spent_on(stripe) * self.stripe.correlated
        return _Belief.of(
            problem,
            place,
            self.dots.updated(
                place.dots.residual, self.dots_weight, covariance.freedom_spent_on(dots)
            ),
            self.stripe.updated(residual, weight, spent),
        )

    def with_runs_at(self, problem: Problem, place: _Place) -> "_Belief":
        """Count stripe points that repeat their neighbours once."""
        table = problem.observations.stripe
        present = problem.stripe_in[table.view]
        run = correlated_run(
            place.stripe.residual[present, 0],
            self.stripe_weight[present],
            table.view[present],
            table.along_px[present],
        )
        return _Belief.of(problem, place, self.dots, replace(self.stripe, correlated=run))

    def equations(
        self, problem: Problem, place: _Place
    ) -> tuple[NormalEquations, NormalEquations, NormalEquations]:
        """Return the normal equations of dots, of stripe, and of everything with the prior."""
        seen = problem.observations
        dots = NormalEquations.of(
            place.dots, self.dots_weight / self.dots.variance, seen.dots.view, seen.count
        )
        stripe = NormalEquations.of(
            place.stripe, self.stripe_weight / self.stripe.variance, seen.stripe.view, seen.count
        )
        total = dots + stripe
        if problem.prior is not None:
            size = problem.layout.size
            free = list(problem.layout.camera)
            information, gap = np.zeros((size, size)), np.zeros(size)
            information[: len(free), : len(free)] = problem.prior.information
            gap[: len(free)] = (problem.prior.camera - place.estimate.camera)[free]
            total = total.with_prior(information, gap)
        return dots, stripe, total

    def cost(self, problem: Problem, place: _Place) -> float:
        """Return the cost of a place under these weights."""
        squares = (place.dots.residual**2).sum(axis=1) @ self.dots_weight / self.dots.variance
        stripe = (place.stripe.residual**2)[:, 0] @ self.stripe_weight / self.stripe.variance
        prior = 0.0
        if problem.prior is not None:
            free = list(problem.layout.camera)
            gap = (problem.prior.camera - place.estimate.camera)[free]
            prior = float(gap @ problem.prior.information @ gap)
        return float(squares + stripe + prior) / 2.0

    def differs_from(self, other: "_Belief") -> bool:
        """Tell whether the scales still move."""
        return any(
            abs(mine.scale - theirs.scale) > _SCALE_SETTLED * theirs.scale or not mine.settled
            for mine, theirs in ((self.dots, other.dots), (self.stripe, other.stripe))
        )


def solve(problem: Problem, start: Estimate, *, near: bool) -> Solution:
    """Find the most likely poses, and as the layout says light plane and camera.

    Parameters
    ----------
    problem
        Points, free parameters, prior.
    start
        Where to begin.
    near
        The start explains most points about as well as the answer will, so that gross errors
        stand out at once. A point then pulls only if it is likely to be good; else all pull, but
        none by more than a little, until the answer is near.

    Returns
    -------
    Solution
        Its covariance is scaled by the scatter seen.

    Raises
    ------
    NotConverged
        If no step lowers the cost any more, or the steps do not end.

    Notes
    -----
    A damped Gauss-Newton (Levenberg-Marquardt) walk on the weighted squares. The weights are fixed
    within a step and renewed after it, so that each step lowers the mixture's negative logarithm.
    """
    rays = normalised_of(problem.observations.stripe.seen_px, start.camera)
    place = _Place.at(problem, start, rays)
    belief = (_Belief.from_near if near else _Belief.from_medians)(problem, place)
    parameters = problem.layout.size + POSE_SIZE * problem.observations.count
    damping = _FIRST_DAMPING
    moving, runs_counted = True, False
    for iteration in range(1, _ITERATIONS + 1):
        total = belief.equations(problem, place)[2]
        global_step, pose_steps, decrement = _step(total, damping)
        if decrement <= _ARRIVED**2 and not moving:
            if runs_counted:
                return _solution(problem, place, belief, iteration)
            # Once, at the end: counted at every step, a run at the edge of significance would
            # come and go and the walk not end.
            belief, runs_counted = belief.with_runs_at(problem, place), True
            continue
        trial = problem.layout.moved(place.estimate, global_step, pose_steps)
        trial_place = _Place.at(problem, trial, rays)
        fall = total.cost - belief.cost(problem, trial_place)
        # Near the end the cost cannot fall by more than its own rounding.
        if fall >= -1e-12 * (1.0 + total.cost):
            place, before = trial_place, belief
            if belief.dots.settled or decrement <= _NEAR**2 * parameters:
                belief = belief.settled_at(problem, place)
            else:
                belief = _Belief.from_medians(problem, place)
            moving = belief.differs_from(before)
            damping = _eased(damping, fall, decrement)
        elif damping >= _MOST_DAMPING:
            raise NotConverged(
                f"the solve stands still after {iteration} steps; check the target's size and "
                "the pictures' quality"
            )
        else:
            damping = max(damping * 10.0, _FIRST_DAMPING)
    raise NotConverged(
        f"the solve did not end within {_ITERATIONS} steps; check the target's size and the "
        "pictures' quality"
    )


def _eased(damping: float, fall: float, decrement: float) -> float:
    """Return the damping after a step that was taken, by Nielsen's rule.

    It eases where the cost fell as foretold. Where it did not - at large noise a board seen from
    the front is curved in its tilt - it stays, or the walk would go to and fro.
    """
    gain = 2.0 * fall / decrement if decrement > 1e-9 else 1.0
    factor = 1.0 - (2.0 * min(gain, 1.0) - 1.0) ** 3
    return float(np.clip(damping * max(factor, 0.1), _LEAST_DAMPING, _MOST_DAMPING))


def _step(equations: NormalEquations, damping: float) -> tuple[FloatArray, FloatArray, float]:
    try:
        return equations.step(damping)
    except np.linalg.LinAlgError as error:
        raise _undetermined(error) from error


def _covariance(equations: NormalEquations) -> ArrowCovariance:
    try:
        return equations.covariance()
    except np.linalg.LinAlgError as error:
        raise _undetermined(error) from error


def _undetermined(error: np.linalg.LinAlgError) -> NotConverged:
    return NotConverged(
        f"the pictures do not determine the answer ({error}); add pictures of the target in "
        "other places and tilts"
    )


def _solution(problem: Problem, place: _Place, belief: _Belief, iterations: int) -> Solution:
    total = belief.equations(problem, place)[2]
    return Solution(
        estimate=place.estimate,
        dots=place.dots,
        stripe=place.stripe,
        dots_mixture=belief.dots,
        stripe_mixture=belief.stripe,
        covariance=_covariance(total),
        cost=total.cost,
        iterations=iterations,
    )
