"""How far a reading can be trusted: every source of doubt, as motions of the points."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, IntArray
from measure.gauging.estimate import Estimate

COVERAGE_FACTOR = 1.96
"""A normal 95 % interval: the parts are many and small."""
MODEL_FLOOR_MM = 0.002
"""What smoothing leaves of bias, at most, on the arcs of a flange (1.6 um on R = 12 mm)."""
_NO_POWER = 1e-14
PICTURE_FLOOR_MM = 0.006
"""What smoothing and blur leave of bias in readings from pictures: rendered wheels are off by 1 um
in height and 10 um in thickness on the mean; smoothing alone makes 8 um on a sharply worn face."""


@dataclass(frozen=True, slots=True, eq=False)
class Learnt:
    """What was learnt of the causes by comparing points that must agree.

    Attributes
    ----------
    causes
        Shape (U,): the most likely causes, in standard deviations, those of a shot first.
    left
        Shape (U, U): what remains of the true causes when these are taken out.
    noise
        Shape (U, B): what the points' own noise put into them, one sigma each.
    """

    causes: FloatArray
    left: FloatArray
    noise: FloatArray

    def rest(self, by_cause: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return, of changes by each cause, what true causes and noise leave; both (..., K)."""
        return by_cause @ self.left, by_cause @ self.noise


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
    learnt
        What was learnt of these P + Q causes and taken out of the points; None where nothing was.
    """

    own_mm: FloatArray
    once_mm: FloatArray
    shared_mm: FloatArray
    learnt: Learnt | None = None

    @classmethod
    def concatenated(cls, several: Sequence["Motions"]) -> "Motions":
        """Make one of the motions of several sets of points, by the same causes."""
        return cls(
            np.concatenate([each.own_mm for each in several]),
            np.concatenate([each.once_mm for each in several]),
            np.concatenate([each.shared_mm for each in several]),
        )

    def select(self, index: IntArray) -> "Motions":
        """Return those of the points that an index array picks."""
        return replace(
            self,
            own_mm=self.own_mm[index],
            once_mm=self.once_mm[index],
            shared_mm=self.shared_mm[index],
        )

    def displaced_mm(self, causes: FloatArray) -> FloatArray:
        """Return by how much causes, shape (P + Q,) in standard deviations, move the points."""
        split = self.once_mm.shape[2]
        return np.asarray(self.once_mm @ causes[:split] + self.shared_mm @ causes[split:])

    def budget(self, estimate: Estimate, blind_mm: float) -> "Budget":
        """Return what is not known of a value, with the sigma of what no point tells."""
        noise = np.sum(estimate.gradient * self.own_mm, axis=1)
        once, shared = estimate.moved_by(self.once_mm), estimate.moved_by(self.shared_mm)
        if self.learnt is not None:
            split = len(once)
            left, learning = self.learnt.rest(np.concatenate([once, shared]))
            once, shared = np.concatenate([left[:split], learning]), left[split:]
        single = float(noise @ noise + once @ once + blind_mm**2)
        return Budget(float(np.sqrt(single)), shared)


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


def root_of(covariance: FloatArray) -> FloatArray:
    """Return one sigma of each independent part of a covariance.

    Parameters
    ----------
    covariance
        Shape (P, P), perhaps singular.

    Returns
    -------
    root
        Shape (P, Q): root @ root.T is the covariance; Q is its rank.
    """
    # Scaled to a correlation matrix first: focal lengths and distortions differ by ten orders.
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    power, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
    known = power > _NO_POWER
    return np.asarray(safe[:, None] * axes[:, known] * np.sqrt(power[known]))


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
        Shape (N, 2, Q), of the Q parts there are.
    """
    return np.asarray(motion_mm @ root_of(covariance))
