"""How well a rig joins its sensors: what is open is refused, what is doubtful is told."""

from collections.abc import Mapping

import numpy as np

from calib.arrays import FloatArray
from calib.compare_rigs import seen_from
from calib.errors import Degenerate
from calib.rig import Rig
from calib.solving.rig.answer import RigReach
from calib.solving.rig.problem import RigProblem
from calib.solving.rig.turn_axes import axis_text

# One standard deviation along the worst direction: above the first the answer says so, above the
# second there is none.
_DOUBTFUL_MM, _HOPELESS_MM = 0.15, 1.0
_MOST_POINTS = 60


def reach_of(rig: Rig, problem: RigProblem) -> Mapping[str, RigReach]:
    """Return how well the points of every sensor but the anchor are known in its frame.

    Raises
    ------
    Degenerate
        If the points of a sensor are known to no better than a millimetre.
    """
    found, anchor = {}, problem.sensors[problem.layout.anchor]
    for index, name in enumerate(problem.sensors):
        if name == anchor:
            continue
        _, covariance = seen_from(rig, name, anchor, _lit_pixels(problem, index))
        known = np.isfinite(covariance).all(axis=(1, 2))
        values, axes = np.linalg.eigh(covariance[known].mean(axis=0))
        reach = RigReach(float(np.sqrt(values[-1])), axes[:, -1])
        if not reach.sigma_mm <= _HOPELESS_MM:
            raise Degenerate(
                f"the points of {name!r} are known beside those of {anchor!r} to "
                f"{reach.sigma_mm:.2g} mm only, along {axis_text(reach.direction)} in the frame of "
                f"its camera; {_CURE}"
            )
        found[name] = reach
    return found


_CURE = (
    "add showings with the target turned by 20 degrees and more about two axes, as far off each "
    "other as both cameras can see it"
)


def reach_warnings(reach: Mapping[str, RigReach]) -> tuple[str, ...]:
    """Tell of sensors that are joined poorly."""
    return tuple(
        f"the points of {name!r} are known in the rig to {each.sigma_mm:.2g} mm only, along "
        f"{axis_text(each.direction)} in the frame of the anchor's camera; {_CURE}"
        for name, each in reach.items()
        if each.sigma_mm > _DOUBTFUL_MM
    )


def _lit_pixels(problem: RigProblem, sensor: int) -> FloatArray:
    """Return pixels where a sensor saw its stripe; without any, where it saw the target."""
    tables = [problem.channels[index] for index in problem.of_sensor(sensor)]
    pixels = np.concatenate([each.observations.stripe.seen_px[each.stripe_in] for each in tables])
    if len(pixels) == 0:
        pixels = np.concatenate([each.observations.dots.seen_px for each in tables])
    return np.asarray(pixels[:: -(-len(pixels) // _MOST_POINTS)])
