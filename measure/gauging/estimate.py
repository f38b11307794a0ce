"""A number read off measured points, and how it moves when they do."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A value with its gradient: to first order it moves by the sum of gradient times motion.

    Everything uncertain (noise of the stripe, calibration, survey, axle) moves the points of the
    section; one gradient therefore serves to propagate all of it.

    Attributes
    ----------
    value
        mm.
    gradient
        Shape (N, 2): change of the value for a motion of each point (a, r).
    """

    value: float
    gradient: FloatArray

    @classmethod
    def exact(cls, value: float, count: int) -> "Estimate":
        """Make a value that no motion of the `count` points changes."""
        return cls(value, np.zeros((count, 2)))

    def __add__(self, other: "Estimate | float") -> "Estimate":
        if isinstance(other, Estimate):
            return Estimate(self.value + other.value, self.gradient + other.gradient)
        return Estimate(self.value + other, self.gradient)

    def __sub__(self, other: "Estimate | float") -> "Estimate":
        if isinstance(other, Estimate):
            return Estimate(self.value - other.value, self.gradient - other.gradient)
        return Estimate(self.value - other, self.gradient)

    def moved_by(self, motion_mm: FloatArray) -> FloatArray:
        """Return how much the value changes for motions of the points.

        Parameters
        ----------
        motion_mm
            Shape (N, 2), or (N, 2, K) for K motions.

        Returns
        -------
        change_mm
            Shape () or (K,).
        """
        return np.asarray(np.tensordot(self.gradient, motion_mm, axes=([0, 1], [0, 1])))
