"""The robust maximum-likelihood solve of a rig: all poses, sensors and dots together."""

from dataclasses import dataclass

from calib.errors import NotConverged
from calib.solving.joint.damping import Damping, descends
from calib.solving.joint.normal_equations import ArrowCovariance
from calib.solving.rig.belief import RigBelief, RigPlace
from calib.solving.rig.problem import RigProblem
from calib.solving.rig.unknowns import RigState

_ITERATIONS = 100
# Then the scales are held and the weights alone renewed, which must come to an end.
_SETTLING = 30
# A step shorter than this many standard deviations (of all parameters together) is an arrival.
_ARRIVED = 1e-3
_FIRST_DAMPING = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class RigSolution:
    """The end of a solve that converged.

    Attributes
    ----------
    place, belief
        The answer with its residuals; how far each point is believed there.
    covariance
        Of dots and unknowns, scaled by the scatter seen.
    cost
        Half the weighted sum of squares, priors included.
    iterations
        Steps taken.
    """

    place: RigPlace
    belief: RigBelief
    covariance: ArrowCovariance
    cost: float
    iterations: int


def solve_rig(problem: RigProblem, start: RigState) -> RigSolution:
    """Find the most likely rig from a start that explains most points fairly.

    Raises
    ------
    NotConverged
        If the pictures leave an unknown undetermined, no step lowers the cost any more, or the
        steps do not end.

    Notes
    -----
    A damped Gauss-Newton walk as in `calib.solving.joint.solve`, the weights fixed within a step
    and renewed after it.
    """
    place = RigPlace.at(problem, start)
    belief = RigBelief.from_medians(problem, place)
    damping = Damping(_FIRST_DAMPING)
    moving, runs_counted = True, False
    for iteration in range(1, _ITERATIONS + 1):
        total = belief.equations(problem, place)[1]
        step, dot_steps, decrement = total.step(damping.value)
        if decrement <= _ARRIVED**2 and not moving:
            if runs_counted:
                return RigSolution(place, belief, total.covariance(), total.cost, iteration)
            # Once, at the end: a run at the edge of significance would come and go. The scales are
            # held from then on: runs that are the misfit of a bent sensor would let them grow until
            # its stripes are all scatter, and its prior is all that is left.
            belief, runs_counted = belief.with_runs_at(problem, place), True
            continue
        trial = RigPlace.at(problem, problem.layout.moved(place.state, step, dot_steps))
        fall = total.cost - belief.cost(problem, trial)
        if descends(fall, total.cost):
            place, before = trial, belief
            held = runs_counted or iteration > _SETTLING
            renew = belief.held_at if held else belief.settled_at
            belief = renew(problem, place)
            moving = belief.differs_from(before)
            damping = damping.eased(fall, decrement)
        elif damping.exhausted:
            raise NotConverged(
                f"the solve of the rig stands still after {iteration} steps; check the boards' "
                "size and the pictures' quality"
            )
        else:
            damping = damping.raised()
    raise NotConverged(
        f"the solve of the rig did not end within {_ITERATIONS} steps; check the boards' size and "
        "the pictures' quality"
    )
