"""The lens: blur by diffraction, aberration and defocus, flare, and the fall of light."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calib import CameraModel
from station.scenes.patch import Counts

_FLARE_SCALE = 8  # flare is so wide that it is worked out in blocks of 8 x 8 pixels


@dataclass(frozen=True, slots=True)
class Lens:
    """A 12 mm lens at f/5.6 on 5.5 um pixels, focused at the working distance.

    Attributes
    ----------
    blur_px
        Standard deviation of the point spread in focus.
    focus_mm
        Distance of best focus along the axis.
    defocus_px
        Standard deviation of the blur that adds, in squares, per unit of ``1 - focus / z``.
        A circle of diameter c blurs by c / 4; c = aperture (12.7 / 5.6 mm) x magnification.
    flare, flare_px
        Shares of the light that go into wide halos, and their standard deviations.
    corner
        Share of the light lost at the corner of the picture.
    """

    blur_px: float = 0.85
    focus_mm: float = 486.0
    defocus_px: float = 2.7
    flare: tuple[float, float] = (0.02, 0.012)
    flare_px: tuple[float, float] = (10.0, 60.0)
    corner: float = 0.18

    def blur_sigma_px(self, depth_mm: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the standard deviation of the point spread at depths, any shape."""
        defocus = self.defocus_px * (1.0 - self.focus_mm / depth_mm)
        return np.asarray(np.hypot(self.blur_px, defocus), dtype=np.float32)

    def blur(self, light: Counts, depth_mm: NDArray[np.float32]) -> Counts:
        """Blur a window of light as its depth, of the same shape, asks.

        The spread varies slowly over a window: a pixel takes its light from two pictures, of the
        least and the greatest blur, mixed so that its variance is right.
        """
        sigma = self.blur_sigma_px(depth_mm)
        least, greatest = float(sigma.min()), float(sigma.max())
        sharp = cv2.GaussianBlur(light, (0, 0), least)
        if greatest - least < 0.02:
            return np.asarray(sharp)
        share = (sigma**2 - least**2) / (greatest**2 - least**2)
        return np.asarray(sharp + share * (cv2.GaussianBlur(light, (0, 0), greatest) - sharp))

    def finish(self, light: Counts, camera: CameraModel) -> Counts:
        """Add the flare to a whole picture and take the light the corners lose."""
        height, width = light.shape
        small = cv2.resize(
            light,
            (max(1, width // _FLARE_SCALE), max(1, height // _FLARE_SCALE)),
            interpolation=cv2.INTER_AREA,
        )
        halo = np.zeros(small.shape, dtype=np.float32)
        for share, sigma_px in zip(self.flare, self.flare_px, strict=True):
            wide = cv2.GaussianBlur(small, (0, 0), sigma_px / _FLARE_SCALE)
            halo += np.asarray(np.float32(share) * wide, dtype=np.float32)
        kept = light * np.float32(1.0 - sum(self.flare))
        kept += cv2.resize(halo, (width, height), interpolation=cv2.INTER_LINEAR)
        kept *= self._fall(camera)
        return np.asarray(kept)

    def _fall(self, camera: CameraModel) -> Counts:
        v = (np.arange(camera.height, dtype=np.float32) - np.float32(camera.cy))[:, None]
        u = (np.arange(camera.width, dtype=np.float32) - np.float32(camera.cx))[None, :]
        corner_px2 = (camera.width**2 + camera.height**2) / 4.0
        return np.asarray(1.0 - self.corner / corner_px2 * (u * u + v * v), dtype=np.float32)
