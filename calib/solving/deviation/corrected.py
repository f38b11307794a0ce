"""Points corrected by their deviations, and what the deviations show of the sigmas."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.solving.deviation.state import RIGID, Frame, State
from calib.solving.joint.mixture import correlated_run
from calib.solving.joint.parameters import PLANE_SIZE, POSE_SIZE
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.observations import Observations

# A correction that stops this many sigmas short was stopped by its bound: the search leaves a
# hundredth of this where nothing hinders it.
_STOPPED_SHORT = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Corrected:
    """The points that took part.

    Attributes
    ----------
    seen, observations
        N dots and S stripe points as seen, and corrected.
    state
        Their deviations.
    dots_free, stripe_free
        Shapes (N,) and (S,): the deviation needed is within its bounds.
    """

    seen: Observations
    observations: Observations
    state: State
    dots_free: BoolArray
    stripe_free: BoolArray

    @classmethod
    def of(cls, frame: Frame, state: State) -> "Corrected":
        """Correct what is seen by the deviations of a state."""
        seen = frame.observations
        moved = replace(
            seen,
            dots=replace(seen.dots, seen_px=seen.dots.seen_px - state.dots_px),
            stripe=replace(seen.stripe, seen_px=seen.stripe.seen_px - state.stripe_px),
        )
        dots = linearise_dots(moved, state.estimate, RIGID).residual
        stripe = linearise_stripe(moved.stripe, state.estimate, RIGID).residual
        return cls(
            seen,
            moved,
            state,
            np.asarray(np.abs(dots).max(axis=1) < _STOPPED_SHORT),
            np.asarray(np.abs(stripe[:, 0]) < _STOPPED_SHORT),
        )

    @property
    def scale_dots(self) -> float:
        """Actual over predicted scatter of the dots, each pose having spent six of them."""
        used = (self.state.dots_px / self.seen.dots.sigma_px)[self.dots_free]
        return _scale(used, used.size - POSE_SIZE * self.seen.count)

    @property
    def scale_stripe(self) -> float:
        """Actual over predicted scatter of the stripe points."""
        used = self._stripe_in_sigma[self.stripe_free]
        return _scale(used, used.size - PLANE_SIZE)

    @property
    def stripe_run(self) -> float:
        """How many neighbouring stripe points carry the information of one."""
        table, free = self.seen.stripe, self.stripe_free
        residual = self._stripe_in_sigma[free]
        return correlated_run(
            residual, np.ones_like(residual), table.view[free], table.along_px[free]
        )

    @property
    def _stripe_in_sigma(self) -> FloatArray:
        across = np.einsum("ni,ni->n", self.state.stripe_px, self.seen.stripe.normal)
        return np.asarray(across / self.seen.stripe.sigma_px)


def _scale(in_sigma: FloatArray, freedom: int) -> float:
    return float(np.sqrt((in_sigma**2).sum() / freedom)) if freedom > 0 else 1.0
