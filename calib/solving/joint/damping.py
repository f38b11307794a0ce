"""How much the steps of a damped Gauss-Newton walk are held back, from one to the next."""

from dataclasses import dataclass

import numpy as np

_LEAST, _MOST = 1e-12, 1e10
_FIRST_RAISING = 4.0
# Of the cost: what its own rounding may be.
_ROUNDING = 1e-12
# Steps this small tell nothing of how well the cost was foretold.
_LEAST_DECREMENT = 1e-9
# By how much one good step eases at the most.
_MOST_EASING = 0.1


@dataclass(frozen=True, slots=True)
class Damping:
    """The damping of the next step, and how fast it rises while steps fail.

    Attributes
    ----------
    value
        What the diagonal of the normal equations is raised by, as part of itself.
    raising
        The factor after a step that fails.
    """

    value: float
    raising: float = _FIRST_RAISING

    @property
    def exhausted(self) -> bool:
        """No step that is held back more could be told from none."""
        return self.value >= _MOST

    def raised(self) -> "Damping":
        """Return the damping after a step that failed, ever faster.

        In a curved valley the damping that just works is found in small steps, and from afar it
        is soon there.
        """
        return Damping(self.value * self.raising, self.raising * _FIRST_RAISING)

    def eased(self, fall: float, decrement: float) -> "Damping":
        """Return the damping after a step that was taken, by Nielsen's rule [1]_.

        It eases where the cost fell as foretold. Where it fell by half of that or less - at large
        noise a board seen from the front is curved in its tilt - it stays or rises, to the double
        at most, or the walk would go to and fro.

        Parameters
        ----------
        fall
            By how much the cost fell.
        decrement
            Right side of the normal equations times step, about twice the fall they foretold.

        References
        ----------
        .. [1] H. B. Nielsen, "Damping parameter in Marquardt's method", report IMM-REP-1999-05,
           Technical University of Denmark, 1999.
        """
        gain = 2.0 * fall / decrement if decrement > _LEAST_DECREMENT else 1.0
        factor = 1.0 - (2.0 * min(gain, 1.0) - 1.0) ** 3
        return Damping(float(np.clip(self.value * max(factor, _MOST_EASING), _LEAST, _MOST)))


def descends(fall: float, cost: float) -> bool:
    """Tell whether a step lowers the cost; near the end, by no more than its own rounding."""
    return fall >= -_ROUNDING * (1.0 + cost)
