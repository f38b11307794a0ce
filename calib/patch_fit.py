"""Least squares on many small windows at once: the centre of a mark, and how well it is known."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.noise import SATURATED_FROM, PixelNoise

Evaluate = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""(parameters (N, P), places (K, 2)) -> brightness (N, K), derivatives (N, P, K)"""
Sound = Callable[[FloatArray, FloatArray], FloatArray]
"""(parameters after a step, before) -> parameters that make sense"""

SCALES_PX = (1.0, 2.0)
"""Gaussian kernels of the multi-scale spread, besides the picture as it is."""

_TOLERANCE_PX = 2e-4
_DAMPING = 1e-3
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
    samples: FloatArray
    weight: FloatArray
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
        samples = picture[v, u].astype(np.float64)
        weight = (use & inside) / noise.variance(smooth[v, u].astype(np.float64))
        return cls(origin, offset, samples, weight, samples >= SATURATED_FROM)

    def without(self, hidden: BoolArray) -> "Patches":
        """Return the same with the pixels of a mask, shape (N, K), not used."""
        return replace(self, weight=np.where(hidden, 0.0, self.weight))

    def places_px(self) -> FloatArray:
        """Return where the pixels are in the picture, shape (N, K, 2)."""
        return (self.origin[:, None, :] + self.offset).astype(np.float64)

    def of(self, other: Picture) -> FloatArray:
        """Return the same pixels of another picture, shape (N, K)."""
        u = np.clip(self.origin[:, 0, None] + self.offset[:, 0], 0, other.shape[1] - 1)
        v = np.clip(self.origin[:, 1, None] + self.offset[:, 1], 0, other.shape[0] - 1)
        return other[v, u].astype(np.float64)


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


def fit_patches(
    patches: Patches,
    parameters: FloatArray,
    evaluate: Evaluate,
    sound: Sound,
    *,
    iterations: int = 12,
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
    iterations
        The most steps taken.

    Notes
    -----
    A clipped pixel says "at least this": it pulls only while the model is below it. After some
    steps pixels farther off than three times the scatter of their window lose weight
    (Geman-McClure), so that a foreign edge does not pull.
    """
    parameters = parameters.copy()
    count = len(parameters)
    converged = np.zeros(count, dtype=bool)
    robust = np.ones_like(patches.weight)
    for iteration in range(iterations):
        todo = np.flatnonzero(~converged)
        if todo.size == 0:
            break
        part = _rows(patches, todo)
        model, jacobian = evaluate(parameters[todo], patches.offset.astype(np.float64))
        residual, weight = _pull(part, model)
        if iteration >= 3:
            robust[todo] = _robust_weight(residual, weight)
        step = _step(jacobian, residual, weight * robust[todo])
        after = sound(parameters[todo] + step, parameters[todo])
        moved = np.abs(after - parameters[todo])[:, :2].max(axis=1)
        parameters[todo] = after
        converged[todo] = (moved < _TOLERANCE_PX) & (iteration >= 4)
    model, jacobian = evaluate(parameters, patches.offset.astype(np.float64))
    residual, weight = _pull(patches, model)
    scatter = _scatter(residual, weight)
    normal = _normal(jacobian, weight * robust)
    covariance = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)[:, :2, :2]
    covariance = covariance * np.maximum(scatter, 1.0)[:, None, None] ** 2
    return PatchFit(parameters, covariance, scatter, converged)


def spread_over_scales(
    picture: Picture,
    patches: Patches,
    fit: PatchFit,
    evaluate: Evaluate,
    sound: Sound,
    blur: int,
) -> FloatArray:
    """Return the standard deviation of the centre over Gaussian kernels, shape (N, 2), px.

    `blur` is the place of the parameter that a kernel widens.
    """
    centres = [fit.parameters[:, :2]]
    for scale in SCALES_PX:
        smoothed = np.asarray(cv2.GaussianBlur(picture, (0, 0), scale), dtype=np.uint8)
        start = fit.parameters.copy()
        start[:, blur] = np.hypot(start[:, blur], scale)
        again = fit_patches(
            replace(patches, samples=patches.of(smoothed)), start, evaluate, sound, iterations=2
        )
        centres.append(again.parameters[:, :2])
    return np.asarray(np.std(centres, axis=0))


def _rows(patches: Patches, index: IntArray) -> Patches:
    return Patches(
        patches.origin[index],
        patches.offset,
        patches.samples[index],
        patches.weight[index],
        patches.clipped[index],
    )


def _pull(patches: Patches, model: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals and the weights of those that count."""
    above = patches.clipped & (model >= patches.samples)
    return patches.samples - model, np.where(above, 0.0, patches.weight)


def _normal(jacobian: FloatArray, weight: FloatArray) -> FloatArray:
    return (jacobian * weight[:, None, :]) @ jacobian.transpose(0, 2, 1)


def _step(jacobian: FloatArray, residual: FloatArray, weight: FloatArray) -> FloatArray:
    """Return a step of Gauss-Newton, damped in each parameter's own scale."""
    normal = _normal(jacobian, weight)
    gradient = jacobian @ (weight * residual)[:, :, None]
    size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), 1e-30))
    scaled = normal / (size[:, :, None] * size[:, None, :]) + _DAMPING * np.eye(size.shape[1])
    return np.asarray(np.linalg.solve(scaled, gradient / size[:, :, None])[:, :, 0] / size)


def _scatter(residual: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the robust rms of whitened residuals over the pixels used."""
    used = weight > 0.0
    size = np.where(used, np.abs(residual) * np.sqrt(weight), np.nan)
    none = ~used.any(axis=1)
    size[none] = 1.0
    return np.asarray(np.nanmedian(size, axis=1) / 0.6745)


def _robust_weight(residual: FloatArray, weight: FloatArray) -> FloatArray:
    scale = _CLEAN_SIGMAS * np.maximum(_scatter(residual, weight), 1.0)[:, None]
    square = (residual**2 * weight) / scale**2
    return np.asarray(1.0 / (1.0 + np.maximum(square - 1.0, 0.0)) ** 2)
