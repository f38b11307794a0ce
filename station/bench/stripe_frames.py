"""Frames of 2048 x 1088 px with one stripe from side to side, whose place is exactly known."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.special import ndtr

from calib import FloatArray, Picture

WIDTH_PX, HEIGHT_PX = 2048, 1088
_SLOPE, _BEND_PER_PX = 0.06, 2e-5
_MIDDLE_PX = (1023.5, 520.3)
_GROUND = 12.0
_READ_NOISE, _SHOT_GAIN = 1.5, 0.05


class Glare(StrEnum):
    """What else is in the frame."""

    NONE = "clean"
    GLARE = "glare"


@dataclass(frozen=True, slots=True)
class StripeFrame:
    """A stripe of Gaussian profile, gently bent, averaged over the pixels' area.

    Attributes
    ----------
    width_px
        Standard deviation of its profile.
    height
        Its brightness over the ground, counts.
    glare
        With it two clipped reflections with their halos stand in the frame, one on the stripe,
        and the ground brightens from side to side.
    """

    width_px: float = 2.0
    height: float = 150.0
    glare: Glare = Glare.NONE

    def light(self) -> FloatArray:
        """Return the brightness free of noise, shape (H, W)."""
        u = np.arange(WIDTH_PX, dtype=np.float64)
        v = np.arange(HEIGHT_PX, dtype=np.float64)[:, None]
        centre, slope = _curve(u)
        down_px = self.width_px * np.sqrt(1.0 + slope**2)
        mean = ndtr((v + 0.5 - centre) / down_px) - ndtr((v - 0.5 - centre) / down_px)
        stripe = self.height * np.sqrt(2.0 * np.pi) * down_px * mean
        ground = _GROUND if self.glare is Glare.NONE else _glare(u, v)
        return np.asarray(stripe + ground)

    def taken(self, rng: np.random.Generator, *, white_noise: float | None = None) -> Picture:
        """Return a picture with shot and read noise, or with white noise of so many counts."""
        light = self.light()
        sigma = np.sqrt(_READ_NOISE**2 + _SHOT_GAIN * light) if white_noise is None else white_noise
        noisy = light + rng.normal(size=light.shape) * sigma
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def off_stripe_px(points_px: FloatArray) -> FloatArray:
    """Return how far points, shape (N, 2), are from the true centre line, across it, shape (N,)."""
    centre, slope = _curve(points_px[:, 0])
    return np.asarray((points_px[:, 1] - centre) / np.sqrt(1.0 + slope**2))


def _curve(u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the row of the centre line in each column and its slope: a radius of 25,000 px."""
    from_middle = u - _MIDDLE_PX[0]
    row = _MIDDLE_PX[1] + _SLOPE * from_middle + _BEND_PER_PX * from_middle**2
    return row, _SLOPE + 2.0 * _BEND_PER_PX * from_middle


def _glare(u: FloatArray, v: FloatArray) -> FloatArray:
    """Return a ground with reflections: a clipped core each, and a halo ten times as wide."""
    ground = _GROUND + 40.0 * u / WIDTH_PX + 0.0 * v
    for at_u, at_v, reach in ((700.0, 505.0, 30.0), (1500.0, 300.0, 50.0)):
        squared = (u - at_u) ** 2 + (v - at_v) ** 2
        ground = ground + 600.0 * np.exp(-0.5 * squared / reach**2)
        ground = ground + 40.0 * np.exp(-0.5 * squared / (10.0 * reach) ** 2)
    return np.asarray(ground)
