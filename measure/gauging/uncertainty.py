"""How far a reading can be trusted: every source of doubt, as motions of the points."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.gauging.estimate import Estimate

COVERAGE_FACTOR = 1.96
"""A normal 95 % interval: the parts are many and small."""
MODEL_FLOOR_MM = 0.002
"""What smoothing leaves of bias, at most, on the arcs of a flange (1.6 um on R = 12 mm)."""
PICTURE_FLOOR_MM = 0.006
"""What smoothing and blur leave of bias in readings from pictures: rendered wheels are off by 1 um
in height and 10 um in thickness on the mean; smoothing alone makes 8 um on a sharply worn face."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """What the points of a section may do, one sigma each.

    Attributes
    ----------
    own_mm
        Shape (N, 2): each point by itself, across the stripe (the picture's noise).
    once_mm
        Shape (N, 2, P): all together, afresh in every picture (place of the axle).
    shared_mm
        Shape (N, 2, Q): all together, the same in every picture of the wheel (calibration, survey,
        radius).
    """

    own_mm: FloatArray
    once_mm: FloatArray
    shared_mm: FloatArray

    def budget(self, estimate: Estimate, blind_mm: float) -> "Budget":
        """Return what is not known of a value, with the sigma of what no point tells."""
        noise = np.sum(estimate.gradient * self.own_mm, axis=1)
        once = estimate.moved_by(self.once_mm)
        single = float(noise @ noise + once @ once + blind_mm**2)
        return Budget(float(np.sqrt(single)), estimate.moved_by(self.shared_mm))


@dataclass(frozen=True, slots=True, eq=False)
class Budget:
    """Standard deviation of a value: its own part, and parts it shares with other pictures.

    Attributes
    ----------
    single_mm
        Independent from picture to picture.
    shared_mm
        Shape (Q,): change for one sigma of each shared cause.
    """

    single_mm: float
    shared_mm: FloatArray

    @property
    def sigma_mm(self) -> float:
        """Of all parts together."""
        return float(np.sqrt(self.single_mm**2 + self.shared_mm @ self.shared_mm))

    @property
    def u95_mm(self) -> float:
        """Half-width of the 95 % interval, with the floor of the model."""
        return COVERAGE_FACTOR * float(np.hypot(self.sigma_mm, MODEL_FLOOR_MM))


def whitened(motion_mm: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return motions for one sigma of each independent part of a covariance.

    Parameters
    ----------
    motion_mm
        Shape (N, 2, P): per unit of each of P parameters.
    covariance
        Shape (P, P), perhaps singular.

    Returns
    -------
    motion_mm
        Shape (N, 2, P).
    """
    # Scaled to a correlation matrix first: focal lengths and distortions differ by ten orders.
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    power, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
    root = safe[:, None] * axes * np.sqrt(np.maximum(power, 0.0))
    return np.asarray(motion_mm @ root)
