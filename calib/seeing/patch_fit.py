"""Least squares on many small windows at once: the centre of a mark, and how well it is known."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.seeing.coherence import coherence_of
from calib.seeing.patches import Patches, masked_median

Evaluate = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""(parameters (N, P), places (K, 2)) -> brightness (N, K), derivatives (N, P, K)

It computes in the precision of its parameters; single is enough for a step and twice as fast."""
Sound = Callable[[FloatArray, FloatArray], FloatArray]
"""(parameters after a step, before) -> parameters that make sense"""

_DAMPING = 1e-3
_RIDGE = 1e-9  # keeps an inverse where nothing tells a parameter, which is then badly known
_CLEAN_SIGMAS = 3.0


@dataclass(frozen=True, slots=True)
class Effort:
    """When a fit is good enough.

    Attributes
    ----------
    tolerance_px
        The centre moves less.
    steps_before_robust
        Steps before the weights let go of what is far off: a poor start is itself far off.
    most_steps
        Steps after which those that still move are taken as they are.
    """

    tolerance_px: float = 2e-4
    steps_before_robust: int = 2
    most_steps: int = 30


FULL = Effort()
"""Of a fit that is the only one; the next two are of a first fit, and of one that starts there."""
ROUGHLY = Effort(tolerance_px=0.01, most_steps=8)
AGAIN = Effort(tolerance_px=5e-4, steps_before_robust=0, most_steps=16)


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is known of N windows' parameters besides their pixels.

    Attributes
    ----------
    mean
        Shape (N, P).
    precision
        Shape (N, P, P), inverse covariance; 0 for a parameter of which nothing is known.
    noise
        Shape (N,): variance of what disturbs the pixels, over what their weights say.
    """

    mean: FloatArray
    precision: FloatArray
    noise: FloatArray

    @classmethod
    def nothing(cls, shape: tuple[int, ...]) -> Self:
        """Return that nothing is known of parameters of shape (N, P)."""
        return cls(np.zeros(shape), np.zeros((*shape, shape[1])), np.ones(shape[0]))

    @property
    def weight(self) -> FloatArray:
        """Precision on the scale of the pixels' weights, shape (N, P, P)."""
        return np.asarray(self.precision * self.noise[:, None, None])

    def pull(self, parameters: FloatArray) -> FloatArray:
        """Return how parameters are drawn to the mean, shape (N, P)."""
        return np.asarray((self.weight @ (self.mean - parameters)[:, :, None])[:, :, 0])

    def picked(self, index: IntArray) -> "Prior":
        """Return what is known of some windows."""
        return Prior(self.mean[index], self.precision[index], self.noise[index])


@dataclass(frozen=True, slots=True, eq=False)
class PatchFit:
    """What a fit found in each window.

    Attributes
    ----------
    parameters
        Shape (N, P).
    covariance
        Shape (N, 2, 2), of the first two, by the noise of the pixels and the coherence found.
    scatter
        Shape (N,), rms of what is left over what noise explains; 1 where the model is true.
    coherence
        Shape (N,), see `calib.seeing.coherence`.
    converged
        Shape (N,).
    """

    parameters: FloatArray
    covariance: FloatArray
    scatter: FloatArray
    coherence: FloatArray
    converged: BoolArray

    @property
    def sigma_px(self) -> FloatArray:
        """Standard deviation of the centre, shape (N, 2); infinite where nothing tells it."""
        variance = np.einsum("nii->ni", self.covariance)
        return np.sqrt(np.where(variance > 0.0, variance, np.inf))


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Windows beside their model; what is not used has weight 0.

    Attributes
    ----------
    residual, weight
        Shape (N, K).
    jacobian
        Shape (N, P, K).
    scatter
        Shape (N,).
    """

    residual: FloatArray
    weight: FloatArray
    jacobian: FloatArray
    scatter: FloatArray

    @classmethod
    def of(cls, patches: Patches, parameters: FloatArray, evaluate: Evaluate) -> Self:
        """Compare windows with their model; a clipped pixel counts while the model is below it."""
        model, jacobian = evaluate(parameters.astype(np.float32), patches.offset.astype(np.float32))
        above = patches.clipped & (model >= patches.samples)
        residual = patches.samples - model
        weight = np.where(above, np.float32(0.0), patches.weight)
        return cls(residual, weight, jacobian, _scatter(residual, weight))

    def robust(self) -> "Seen":
        """Return the same with less weight on what is farther off than a few times the scatter."""
        scale = (_CLEAN_SIGMAS * np.maximum(self.scatter, 1.0))[:, None]
        square = self.residual**2 * self.weight / (scale**2).astype(np.float32)
        share = np.asarray(1.0 / (1.0 + np.maximum(square - 1.0, 0.0)) ** 2, dtype=np.float32)
        return Seen(self.residual, self.weight * share, self.jacobian, self.scatter)

    def normal(self) -> FloatArray:
        """Return the normal matrix of least squares, shape (N, P, P)."""
        product = (self.jacobian * self.weight[:, None, :]) @ self.jacobian.transpose(0, 2, 1)
        return product.astype(np.float64)

    def step(self, prior: Prior, parameters: FloatArray) -> FloatArray:
        """Return a step of Gauss-Newton, damped in each parameter's own scale, shape (N, P)."""
        pull = (self.jacobian @ (self.weight * self.residual)[:, :, None])[:, :, 0]
        gradient = pull.astype(np.float64) + prior.pull(parameters)
        normal = self.normal() + prior.weight
        size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), 1e-30))
        scaled = normal / (size[:, :, None] * size[:, None, :]) + _DAMPING * np.eye(size.shape[1])
        return np.asarray(np.linalg.solve(scaled, (gradient / size)[:, :, None])[:, :, 0] / size)


def fit_patches(
    patches: Patches,
    parameters: FloatArray,
    evaluate: Evaluate,
    sound: Sound,
    prior: Prior | None = None,
    effort: Effort = FULL,
) -> PatchFit:
    r"""Fit a model to every window by damped Gauss-Newton steps, robustly.

    Parameters
    ----------
    patches
        N windows of K pixels.
    parameters
        Shape (N, P), the start. The first two are the centre.
    evaluate, sound
        The model.
    prior
        What is known of the parameters besides.
    effort
        When to stop.

    Returns
    -------
    PatchFit
        The last parameters, converged or not.

    Notes
    -----
    A clipped pixel says "at least this": it pulls only while the model is below it. After some
    steps pixels farther off than three times the scatter of their window lose weight
    (Geman-McClure), so that a foreign edge does not pull.

    With M the pixels' normal matrix, A a prior's and c the coherence, the covariance is
    :math:`(M + A)^{-1} (c M + A) (M + A)^{-1}`, with A on the scale of the noise.
    """
    parameters = parameters.copy()
    prior = prior or Prior.nothing(parameters.shape)
    converged = np.zeros(len(parameters), dtype=bool)
    for iteration in range(effort.most_steps):
        todo = np.flatnonzero(~converged)
        if todo.size == 0:
            break
        before = parameters[todo]
        seen = Seen.of(patches.picked(todo), before, evaluate)
        if iteration >= effort.steps_before_robust:
            seen = seen.robust()
        after = sound(before + seen.step(prior.picked(todo), before), before)
        moved = np.abs(after - before)[:, :2].max(axis=1)
        parameters[todo] = after
        converged[todo] = (moved < effort.tolerance_px) & (iteration > effort.steps_before_robust)
    seen = Seen.of(patches, parameters, evaluate).robust()
    covariance, coherence = _covariance(seen, prior, patches.offset)
    return PatchFit(parameters, covariance, seen.scatter, coherence, converged)


def _covariance(seen: Seen, prior: Prior, offset: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of the centres, shape (N, 2, 2), and the coherence, (N,)."""
    normal, known = seen.normal(), prior.weight
    size = np.sqrt(np.maximum(np.einsum("nii->ni", normal + known), 1e-12))
    outer = size[:, :, None] * size[:, None, :]
    inverse = np.linalg.inv((normal + known) / outer + _RIDGE * np.eye(size.shape[1])) / outer
    coherence = coherence_of(seen.residual, seen.weight, seen.jacobian, inverse, offset)
    disturbed = normal * np.maximum(coherence, 1.0)[:, None, None]
    disturbed += known * prior.noise[:, None, None]
    to_centre = inverse[:, :2]
    return to_centre @ disturbed @ to_centre.transpose(0, 2, 1), coherence


def _scatter(residual: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the robust rms of whitened residuals, shape (N,), from every third pixel."""
    part = np.s_[:, ::3]
    size = np.abs(residual[part]) * np.sqrt(weight[part])
    median = masked_median(size, weight[part] > 0.0)
    return np.where(median > 0.0, median / 0.6745, 1.0)
