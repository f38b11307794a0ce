"""Least squares on many small windows at once: the centre of a mark, and how well it is known."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import SATURATED_FROM, PixelNoise
from calib.seeing.resample import Float32Array, smoothed

Evaluate = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""(parameters (N, P), places (K, 2)) -> brightness (N, K), derivatives (N, P, K)

It computes in the precision of its parameters; single is enough for a step and twice as fast."""
Sound = Callable[[FloatArray, FloatArray], FloatArray]
"""(parameters after a step, before) -> parameters that make sense"""

SCALES_PX = (1.0, 2.0, 3.5)
"""Gaussian kernels of the multi-scale spread, besides the picture as it is."""

_TOLERANCE_PX = 2e-4
_DAMPING = 1e-3
_MOST_STEPS = 30
_STEPS_BEFORE_ROBUST = 2
_CLEAN_SIGMAS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Pixels of N windows.

    Attributes
    ----------
    origin
        Shape (N, 2), whole pixels.
    offset
        Shape (K, 2), whole pixels from each origin.
    samples
        Shape (N, K), counts.
    weight
        Shape (N, K), 0 where a pixel is not to be used, else 1 / variance.
    clipped
        Shape (N, K), the sensor's limit.
    """

    origin: IntArray
    offset: IntArray
    samples: Float32Array
    weight: Float32Array
    clipped: BoolArray

    @classmethod
    def cut(
        cls,
        picture: Picture,
        smooth: Picture,
        noise: PixelNoise,
        origin: IntArray,
        offset: IntArray,
        use: BoolArray,
    ) -> "Patches":
        """Cut windows; what lies outside the picture is not used.

        `smooth` is the picture a little smoothed: a weight that followed a pixel's own noise
        would favour the dim.
        """
        u = origin[:, 0, None] + offset[:, 0]
        v = origin[:, 1, None] + offset[:, 1]
        height, width = picture.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        u, v = np.clip(u, 0, width - 1), np.clip(v, 0, height - 1)
        samples = picture[v, u].astype(np.float32)
        variance = noise.variance(np.arange(256.0)).astype(np.float32)
        weight = np.where(use & inside, 1.0 / variance[smooth[v, u]], np.float32(0.0))
        return cls(origin, offset, samples, weight, samples >= SATURATED_FROM)

    def without(self, hidden: BoolArray) -> "Patches":
        """Return the same with the pixels of a mask, shape (N, K), not used."""
        return replace(self, weight=np.where(hidden, np.float32(0.0), self.weight))

    def places_px(self) -> FloatArray:
        """Return where the pixels are in the picture, shape (N, K, 2)."""
        return (self.origin[:, None, :] + self.offset).astype(np.float64)

    def cut_out(self, picture: Picture) -> tuple[Picture, IntArray]:
        """Return the part of the picture that holds all windows, and its corner (u, v)."""
        margin = int(np.abs(self.offset).max()) + 8
        limit = np.array(picture.shape)[::-1]
        low = np.clip(self.origin.min(axis=0) - margin, 0, limit - 1)
        high = np.clip(self.origin.max(axis=0) + margin + 1, low + 1, limit)
        return picture[low[1] : high[1], low[0] : high[0]], low

    def of(self, part: Float32Array, corner: IntArray) -> Float32Array:
        """Return the same pixels, shape (N, K), of a picture whose corner is elsewhere."""
        u = self.origin[:, 0, None] + self.offset[:, 0] - corner[0]
        v = self.origin[:, 1, None] + self.offset[:, 1] - corner[1]
        v, u = np.clip(v, 0, part.shape[0] - 1), np.clip(u, 0, part.shape[1] - 1)
        return np.asarray(part[v, u])


@dataclass(frozen=True, slots=True, eq=False)
class PatchFit:
    """What a fit found in each window.

    Attributes
    ----------
    parameters
        Shape (N, P).
    covariance
        Shape (N, 2, 2), of the first two, by the noise of the pixels and the scatter found.
    scatter
        Shape (N,), rms of what is left over what noise explains; 1 where the model is true.
    converged
        Shape (N,).
    """

    parameters: FloatArray
    covariance: FloatArray
    scatter: FloatArray
    converged: BoolArray

    @property
    def sigma_px(self) -> FloatArray:
        """Standard deviation of the centre, shape (N, 2); infinite where nothing tells it."""
        variance = np.einsum("nii->ni", self.covariance)
        return np.sqrt(np.where(variance > 0.0, variance, np.inf))


def fit_patches(
    patches: Patches,
    parameters: FloatArray,
    evaluate: Evaluate,
    sound: Sound,
) -> PatchFit:
    """Fit a model to every window by damped Gauss-Newton steps, robustly.

    Parameters
    ----------
    patches
        N windows of K pixels.
    parameters
        Shape (N, P), the start. The first two are the centre.
    evaluate, sound
        The model.

    Returns
    -------
    PatchFit
        The last parameters, converged or not.

    Notes
    -----
    A clipped pixel says "at least this": it pulls only while the model is below it. After some
    steps pixels farther off than three times the scatter of their window lose weight
    (Geman-McClure), so that a foreign edge does not pull.
    """
    parameters = parameters.copy()
    count = len(parameters)
    normal = np.zeros((count, parameters.shape[1], parameters.shape[1]))
    scatter, converged = np.ones(count), np.zeros(count, dtype=bool)
    for iteration in range(_MOST_STEPS):
        todo = np.flatnonzero(~converged)
        if todo.size == 0:
            break
        residual, weight, jacobian = _seen(patches, parameters, evaluate, todo)
        scatter[todo] = _scatter(residual, weight)
        if iteration >= _STEPS_BEFORE_ROBUST:
            weight = weight * _robust(residual, weight, scatter[todo])
        normal[todo] = _normal(jacobian, weight)
        step = _step(normal[todo], jacobian, weight * residual)
        after = sound(parameters[todo] + step, parameters[todo])
        moved = np.abs(after - parameters[todo])[:, :2].max(axis=1)
        parameters[todo] = after
        converged[todo] = (moved < _TOLERANCE_PX) & (iteration > _STEPS_BEFORE_ROBUST)
    covariance = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)[:, :2, :2]
    covariance = covariance * np.maximum(scatter, 1.0)[:, None, None] ** 2
    return PatchFit(parameters, covariance, scatter, converged)


def spread_over_scales(
    picture: Picture,
    patches: Sequence[Patches],
    fit: PatchFit,
    evaluate: Evaluate,
    blur: int,
) -> FloatArray:
    """Return the standard deviation of the centre over Gaussian kernels, shape (N, 2), px.

    From the fit one step is taken in the picture smoothed by each kernel.

    Parameters
    ----------
    picture
        Shape (H, W).
    patches
        For each of `SCALES_PX`, the windows with what is not to be used there.
    fit, evaluate
        The fit and its model.
    blur
        The place of the parameter that a kernel widens.
    """
    everything = np.arange(len(fit.parameters))
    moves = [np.zeros((everything.size, 2))]
    part, corner = patches[0].cut_out(picture)
    for scale, at_scale in zip(SCALES_PX, patches, strict=True):
        start = fit.parameters.copy()
        start[:, blur] = np.hypot(start[:, blur], scale)
        samples = at_scale.of(smoothed(part.astype(np.float32), scale), corner)
        residual, weight, jacobian = _seen(
            replace(at_scale, samples=samples), start, evaluate, everything
        )
        weight = weight * _robust(residual, weight, _scatter(residual, weight))
        moves.append(_step(_normal(jacobian, weight), jacobian, weight * residual)[:, :2])
    return np.asarray(np.std(moves, axis=0))


def masked_median(values: FloatArray | Float32Array, use: BoolArray) -> FloatArray:
    """Return the median of each row, shape (N,), over the entries used; 0 where none is."""
    ordered = np.sort(np.where(use, values, np.inf), axis=1)
    count = use.sum(axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.where(count > 0, middle, 0.0)


def _seen(
    patches: Patches, parameters: FloatArray, evaluate: Evaluate, index: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return residuals, weights of those that count, and derivatives, of some windows."""
    model, jacobian = evaluate(
        parameters[index].astype(np.float32), patches.offset.astype(np.float32)
    )
    samples, weight = patches.samples[index], patches.weight[index]
    above = patches.clipped[index] & (model >= samples)
    return samples - model, np.where(above, np.float32(0.0), weight), jacobian


def _normal(jacobian: FloatArray, weight: FloatArray) -> FloatArray:
    product = (jacobian * weight[:, None, :]) @ jacobian.transpose(0, 2, 1)
    return product.astype(np.float64)


def _step(normal: FloatArray, jacobian: FloatArray, pull: FloatArray) -> FloatArray:
    """Return a step of Gauss-Newton, damped in each parameter's own scale."""
    gradient = (jacobian @ pull[:, :, None]).astype(np.float64)
    size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), 1e-30))
    scaled = normal / (size[:, :, None] * size[:, None, :]) + _DAMPING * np.eye(size.shape[1])
    return np.asarray(np.linalg.solve(scaled, gradient / size[:, :, None])[:, :, 0] / size)


def _scatter(residual: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the robust rms of whitened residuals, shape (N,), from every third pixel."""
    part = np.s_[:, ::3]
    size = np.abs(residual[part]) * np.sqrt(weight[part])
    median = masked_median(size, weight[part] > 0.0)
    return np.where(median > 0.0, median / 0.6745, 1.0)


def _robust(residual: FloatArray, weight: FloatArray, scatter: FloatArray) -> FloatArray:
    """Return weights that let go of what is farther off than a few times the scatter."""
    scale = (_CLEAN_SIGMAS * np.maximum(scatter, 1.0))[:, None]
    square = residual**2 * weight / (scale**2).astype(np.float32)
    return np.asarray(1.0 / (1.0 + np.maximum(square - 1.0, 0.0)) ** 2, dtype=np.float32)
