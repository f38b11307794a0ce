"""Which showings contradict the others: the target moved between the pictures of two cameras."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import FloatArray
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import POSE_SIZE
from calib.solving.rig.contradicting import contradiction
from calib.solving.rig.place import ChannelPlace
from calib.solving.rig.problem import Channel, RigProblem
from calib.solving.rig.seen import LEAST_BELIEVED
from calib.solving.rig.solve import RigSolution

# Chi square of six that a true showing exceeds once in 10 million; its median.
_MOST_SURPRISE, _MEDIAN_SURPRISE = 43.0, 5.35


@dataclass(frozen=True, slots=True)
class Doubts:
    """How much the showings of a solve contradict each other.

    Attributes
    ----------
    usual
        Of most showings, as a multiple of what their points' scatter makes; 1 and more.
    worst
        The same of the showing that contradicts the most, over what chance allows once in 10
        million: above 1 it is to be left out, unless all contradict alike.
    reasons
        Why it, or several whose points do not fit at all, are to be left out, by name.
    """

    usual: float
    worst: float
    reasons: Mapping[str, str]


def doubts_of(problem: RigProblem, solution: RigSolution) -> Doubts:
    """Tell which showings contradict the others.

    Notes
    -----
    One picture of a showing is freed from the rig, its board by itself before its camera, and all
    else may follow: by how much everything then surprises less is a chi square of 6 (a likelihood
    ratio, by one step of the extended normal equations).
    """
    unfitting = _unfitting(problem, solution)
    if unfitting:
        return Doubts(1.0, np.inf, unfitting)
    surprise, off_mm = _surprises(problem, solution)
    if not np.isfinite(surprise).any():
        return Doubts(1.0, 0.0, {})
    worst = int(np.nanargmax(surprise))
    return Doubts(
        usual=max(float(np.nanmedian(surprise)) / _MEDIAN_SURPRISE, 1.0),
        worst=float(surprise[worst]) / _MOST_SURPRISE,
        reasons={problem.showings[worst]: contradiction(float(off_mm[worst]))},
    )


def _unfitting(problem: RigProblem, solution: RigSolution) -> Mapping[str, str]:
    """Return why showings do not fit: most dots of a picture are not believed."""
    reasons: dict[str, str] = {}
    for channel, at in zip(problem.channels, solution.place.channels, strict=True):
        believed = solution.belief.dots[channel.sensor].believed(at.dots.residual)
        for view, showing in enumerate(channel.showing):
            own = believed[channel.observations.dots.view == view]
            if own.mean() < LEAST_BELIEVED:
                name = problem.sensors[channel.sensor]
                reasons[problem.showings[showing]] = (
                    f"only {own.sum()} of {len(own)} points that {name!r} saw fit the rig: the "
                    "target moved between the pictures, or it is another one"
                )
    return reasons


def _surprises(problem: RigProblem, solution: RigSolution) -> tuple[FloatArray, FloatArray]:
    """Return the chi square of each showing, NaN of single pictures, and by how many mm it is off.

    Of several pictures of a showing, the one that surprises the most counts.
    """
    _, total = solution.belief.equations(problem, solution.place)
    count = len(problem.showings)
    pictures = np.bincount(np.concatenate([each.showing for each in problem.channels]))
    surprise, off_mm = np.full(count, np.nan), np.zeros(count)
    for index, channel in enumerate(problem.channels):
        at = solution.place.channels[index]
        dots, stripe = solution.belief.scaled_weights(problem, index)
        alone = at.alone(channel, dots, stripe)
        by_dots = at.dots_by_pose(channel, dots, len(problem.dot_sigma_mm))
        for view, showing in enumerate(channel.showing):
            if pictures[showing] < 2:
                continue
            freed = _freed(total, alone, at, by_dots, view)
            step, _, chi_square = freed.step(0.0)
            if not surprise[showing] >= chi_square:
                surprise[showing] = chi_square
                off_mm[showing] = _off_mm(channel, at, view, step[-POSE_SIZE:])
    return surprise, off_mm


def _freed(
    total: NormalEquations,
    alone: NormalEquations,
    at: ChannelPlace,
    by_dots: FloatArray,
    view: int,
) -> NormalEquations:
    """Return the equations with one more pose: a step of this picture's board by itself."""
    own = alone.views[view]
    cross = own @ at.chain[view] + alone.border[view] @ at.step_by_own
    return replace(
        total,
        border=np.concatenate([total.border, by_dots[:, :, view]], axis=2),
        shared=np.block([[total.shared, cross.T], [cross, own]]),
        shared_side=np.concatenate([total.shared_side, alone.views_side[view]]),
    )


def _off_mm(channel: Channel, at: ChannelPlace, view: int, step: FloatArray) -> float:
    """Return how far a step of a picture's board moves its middle."""
    middle = channel.observations.dots.board_mm.mean(axis=0)
    return float(np.linalg.norm(step[3:] + np.cross(step[:3], at.estimate.rotation[view] @ middle)))
