"""Gaussian derivatives of a picture at chosen places, and the ridge they show.

Steger's method needs five derivatives of the smoothed picture.  They are computed only at
the pixels that are asked for: a stripe covers a thousandth of the picture.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.seeing.resample import Float32Array

KERNEL_REACH = 3.6
"""Half-width of a kernel in sigmas; beyond it lies 0.03 % of a Gaussian."""

FRACTIONS = 32
"""Places between pixels are taken to 1/32 px; the step from there to the top makes up the rest."""

_BLOCK = 512
_PICKED = (1, 3, 2, 4, 6)  # g_u, g_v, g_uu, g_uv, g_vv of the products (v, u)


@dataclass(frozen=True, slots=True, eq=False)
class Ridge:
    """What the second derivatives say at N places.

    Attributes
    ----------
    normal
        Shape (N, 2), unit, across the ridge.
    gradient
        Shape (N,), along the normal, counts / px.
    curvature
        Shape (N,), along the normal, counts / px^2; negative on a bright ridge.
    along
        Shape (N,), curvature along the ridge.
    """

    normal: FloatArray
    gradient: FloatArray
    curvature: FloatArray
    along: FloatArray

    @classmethod
    def from_derivatives(cls, derivatives: FloatArray) -> "Ridge":
        """Make it of g_u, g_v, g_uu, g_uv, g_vv, shape (N, 5)."""
        gu, gv, guu, guv, gvv = derivatives.T
        mean = 0.5 * (guu + gvv)
        half = np.hypot(0.5 * (guu - gvv), guv)
        # The direction of the strongest (most negative) curvature, by the double angle.
        angle = 0.5 * np.arctan2(-2.0 * guv, gvv - guu)
        normal = np.column_stack([np.cos(angle), np.sin(angle)])
        curvature = mean - half
        gradient = gu * normal[:, 0] + gv * normal[:, 1]
        return cls(normal, gradient, curvature, mean + half)

    def step_px(self) -> FloatArray:
        """Return the steps, shape (N, 2), from the places to the ridge's top (Eq. 2)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(self.curvature < 0.0, -self.gradient / self.curvature, np.inf)
        return np.asarray(np.clip(step, -1e3, 1e3)[:, None] * self.normal)


def kernel_radius(sigma_px: float) -> int:
    """Return the half-width, whole pixels, of the kernels of `sigma_px`."""
    return int(np.ceil(KERNEL_REACH * sigma_px))


def gaussian_rows(sigma_px: float, shift_px: FloatArray) -> FloatArray:
    """Return the 1-D Gaussian and its first two derivatives about shifted centres.

    Parameters
    ----------
    sigma_px
        Width of the Gaussian.
    shift_px
        Shape (N,), where the derivative is wanted, from the middle of the window.

    Returns
    -------
    rows
        Shape (N, 3, K): correlating with a window gives value, slope and curvature. They are
        exact on polynomials up to the second degree, whatever the sampling.
    """
    radius = kernel_radius(sigma_px)
    x = np.arange(-radius, radius + 1) - shift_px[:, None]
    g = np.exp(-0.5 * (x / sigma_px) ** 2)
    g /= g.sum(axis=1, keepdims=True)
    first, second = (g * x).sum(1, keepdims=True), (g * x * x).sum(1, keepdims=True)
    slope = g * (x - first)
    slope /= (slope * x).sum(axis=1, keepdims=True)
    bend = g * (x * x - second)
    bend -= slope * (bend * x).sum(axis=1, keepdims=True)
    bend *= 2.0 / (bend * x * x).sum(axis=1, keepdims=True)
    return np.stack([g, slope, bend], axis=1)


def inside(shape: tuple[int, ...], pixels: FloatArray | IntArray, margin: int) -> BoolArray:
    """Return which pixels (u, v) keep `margin` from the border of a picture of `shape`."""
    u, v = pixels[:, 0], pixels[:, 1]
    return np.asarray(
        (u >= margin) & (v >= margin) & (u < shape[1] - margin) & (v < shape[0] - margin)
    )


@lru_cache(maxsize=32)
def _row_table(sigma_px: float) -> Float32Array:
    """Return the 1-D kernels, shape (FRACTIONS + 1, 3, K), for places -0.5 to 0.5 px off."""
    shift = np.arange(FRACTIONS + 1) / FRACTIONS - 0.5
    return gaussian_rows(sigma_px, shift).astype(np.float32)


def ridge_between_pixels(
    picture: NDArray[np.generic], pixels: IntArray, fraction: IntArray, sigma_px: float
) -> Ridge:
    """Return the ridge at places between pixels, a kernel's radius or more off the border.

    Equation 2 taken from a pixel half a pixel off the top errs by 0.125 / (σg² + σw²) px; taken
    once more where it points to, by nothing that matters.

    Parameters
    ----------
    picture
        Shape (H, W).
    pixels
        Shape (N, 2), whole pixels (u, v).
    fraction
        Shape (N, 2), the place (u, v) from each pixel in steps of ``1 / FRACTIONS`` px, half a
        pixel at most.
    sigma_px
        The kernel's width.
    """
    table, radius = _row_table(sigma_px), kernel_radius(sigma_px)
    derivatives = np.empty((len(pixels), 5))
    if len(pixels) == 0:  # in a picture smaller than a window, none is far enough off the border
        return Ridge.from_derivatives(derivatives)
    corner, size = pixels - radius, 2 * radius + 1
    windows = sliding_window_view(picture, (size, size))
    # The windows of a whole stripe would not stay in the processor's cache.
    for first in range(0, len(pixels), _BLOCK):
        block = np.s_[first : first + _BLOCK]
        columns_u = table.transpose(0, 2, 1)[fraction[block, 0] + FRACTIONS // 2]
        rows_v = table[fraction[block, 1] + FRACTIONS // 2]
        pixels_about = windows[corner[block, 1], corner[block, 0]].astype(np.float32)
        products = rows_v @ pixels_about @ columns_u
        derivatives[block] = products.reshape(-1, 9)[:, _PICKED]
    return Ridge.from_derivatives(derivatives)
