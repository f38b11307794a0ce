"""What the steel that several sensors see tells of all that may move their points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.gauging.uncertainty import Learnt
from measure.merging.overlap import Overlap

_ROUNDS = 4
_HUBER_SIGMAS = 2.0
_PLAUSIBLE_SIGMAS = 5.0
_FREE_MM = 100.0


def learn(overlaps: Sequence[Overlap], before: Learnt | None) -> Learnt | None:
    r"""Return what is learnt of the causes from how far strands lie apart.

    Parameters
    ----------
    overlaps
        Of pairs of sensors.
    before
        What was taken out of their points already: they then lie nearer the truth, on a curved
        profile, but what there is to explain is how far apart they were measured.

    Returns
    -------
    Learnt or None
        None where no two sensors see the same.

    Notes
    -----
    Points are measured at :math:`p + M u + n` with causes :math:`u \sim N(0, I)` and noise n.
    The steel is one, so :math:`m = H u + n'`, with the motions of one sensor less those of the
    other in H. The causes are then :math:`\hat u = K m, K = H^T (H H^T + R)^{-1}`: a vibration is
    taken out as far as it shows above noise and all else that could look like it, and never
    further than was allowed for. What is left of the causes, :math:`u - \hat u`, is
    :math:`(I - K H) u - K n'`: linear in the same causes, whether they are of one shot or shared.

    Stretches that do not agree with the others (dirt, glare) lose weight, by Huber's rule.
    """
    apart = np.concatenate([each.apart_mm for each in overlaps])
    if not len(apart):
        return None
    by_cause = np.concatenate([each.by_cause for each in overlaps])
    if before is not None:
        apart = apart + by_cause @ before.causes
    sigma = np.concatenate([each.sigma_mm for each in overlaps])
    gain, variance = _robust_gain(by_cause, apart, sigma)
    return Learnt(
        causes=gain @ apart,
        left=np.eye(len(gain)) - gain @ by_cause,
        noise=gain * np.sqrt(variance),
    )


def _robust_gain(
    by_cause: FloatArray, apart: FloatArray, sigma: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return K of the most likely causes, and the variance that each misfit then counts with."""
    variance = sigma**2
    for _ in range(_ROUNDS):
        gain = np.linalg.solve(by_cause @ by_cause.T + np.diag(variance), by_cause).T
        score = np.abs(apart - by_cause @ (gain @ apart)) / sigma
        variance = sigma**2 * np.maximum(1.0, score / _HUBER_SIGMAS)
    return np.asarray(gain), np.asarray(variance)


@dataclass(frozen=True, slots=True, eq=False)
class Displacement:
    """By how much one strand was measured aside from another.

    Attributes
    ----------
    shift_mm
        Shape (2,), along a and r.
    sigma_mm
        Shape (2,): standard deviation, of the points' scatter.
    sigmas
        By how many standard deviations, of vibration, rig and scatter together, it differs from 0.
    """

    shift_mm: FloatArray
    sigma_mm: FloatArray
    sigmas: float

    @property
    def plausible(self) -> bool:
        """Whether the two may be of one wheel before one rig."""
        return self.sigmas <= _PLAUSIBLE_SIGMAS


def displacement(overlap: Overlap) -> Displacement | None:
    """Return by how much the other strand lies aside from the one, or None where nothing tells."""
    if len(overlap) < 2 or np.linalg.matrix_rank(overlap.outward) < 2:
        return None
    # By the two shifts alone, which nothing beforehand holds, against stretches that are not alike.
    gain, variance = _robust_gain(overlap.outward * _FREE_MM, overlap.apart_mm, overlap.sigma_mm)
    solver = gain * _FREE_MM
    shift = -solver @ overlap.apart_mm
    scatter = (solver * variance) @ solver.T
    causes = solver @ overlap.by_cause
    odd = shift @ np.linalg.solve(causes @ causes.T + scatter, shift)
    return Displacement(shift, np.sqrt(np.diag(scatter)), float(np.sqrt(odd)))
