"""The robust maximum-likelihood solve: poses, and as wanted the light plane and the camera."""

from calib.errors import NotConverged
from calib.lens import normalised_of
from calib.solving.joint.belief import Belief, Place
from calib.solving.joint.damping import Damping, descends
from calib.solving.joint.parameters import POSE_SIZE, Estimate
from calib.solving.joint.problem import Problem, Solution

_ITERATIONS = 300
# Then the scales are held and the weights alone renewed, which must come to an end: where a few
# exact points sway many, scale and answer can follow each other for hundreds of steps.
_SETTLING = 40
# A step shorter than this many standard deviations (of all parameters together) is an arrival.
_ARRIVED = 1e-3
# A step of less than this many standard deviations a parameter: what is left is noise, not misfit.
_NEAR = 0.5
_FIRST_DAMPING = 1e-4


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
        If the points leave a parameter undetermined, no step lowers the cost any more, or the
        steps do not end.

    Notes
    -----
    A damped Gauss-Newton (Levenberg-Marquardt) walk on the weighted squares. The weights are fixed
    within a step and renewed after it, so that each step lowers the mixture's negative logarithm.
    """
    rays = normalised_of(problem.observations.stripe.seen_px, start.camera)
    place = Place.at(problem, start, rays)
    belief = (Belief.from_near if near else Belief.from_medians)(problem, place)
    parameters = problem.layout.size + POSE_SIZE * problem.observations.count
    damping = Damping(_FIRST_DAMPING)
    moving, runs_counted = True, False
    for iteration in range(1, _ITERATIONS + 1):
        total = belief.equations(problem, place)[2]
        global_step, pose_steps, decrement = total.step(damping.value)
        if decrement <= _ARRIVED**2 and not moving:
            if runs_counted:
                return _solution(problem, place, belief, iteration)
            # Once, at the end: counted at every step, a run at the edge of significance would
            # come and go and the walk not end.
            belief, runs_counted = belief.with_runs_at(problem, place), True
            continue
        trial = problem.layout.moved(place.estimate, global_step, pose_steps)
        trial_place = Place.at(problem, trial, rays)
        fall = total.cost - belief.cost(problem, trial_place)
        if descends(fall, total.cost):
            place, before = trial_place, belief
            if iteration > _SETTLING and belief.dots.settled:
                belief = belief.held_at(problem, place)
            elif belief.dots.settled or decrement <= _NEAR**2 * parameters:
                belief = belief.settled_at(problem, place)
            else:
                belief = Belief.from_medians(problem, place)
            moving = belief.differs_from(before)
            damping = damping.eased(fall, decrement)
        elif damping.exhausted:
            raise NotConverged(
                f"the solve stands still after {iteration} steps; check the target's size and "
                "the pictures' quality"
            )
        else:
            damping = damping.raised()
    raise NotConverged(
        f"the solve did not end within {_ITERATIONS} steps; check the target's size and the "
        "pictures' quality"
    )


def _solution(problem: Problem, place: Place, belief: Belief, iterations: int) -> Solution:
    total = belief.equations(problem, place)[2]
    return Solution(
        estimate=place.estimate,
        dots=place.dots,
        stripe=place.stripe,
        dots_mixture=belief.dots,
        stripe_mixture=belief.stripe,
        covariance=total.covariance(),
        cost=total.cost,
        iterations=iterations,
    )
