"""Rectangles of light: what is rendered finely where something is, and put into the picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib import CameraModel, FloatArray

Counts = NDArray[np.float32]
"""Light as the counts it raises at exposure 1, over the dark level."""


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangle of pixels: rows top to bottom, columns left to right, the ends not included."""

    top: int
    bottom: int
    left: int
    right: int

    @classmethod
    def around(cls, pixels_px: FloatArray, camera: CameraModel, margin_px: int) -> "Window":
        """Return the smallest window around points, shape (N, 2), clipped to the picture.

        A window of no pixels comes back where all points lie outside.
        """
        low = np.floor(pixels_px.min(axis=0)).astype(int) - margin_px
        high = np.ceil(pixels_px.max(axis=0)).astype(int) + margin_px + 1
        left, right = np.clip([low[0], high[0]], 0, camera.width)
        top, bottom = np.clip([low[1], high[1]], 0, camera.height)
        return cls(int(top), int(bottom), int(left), int(right))

    @classmethod
    def whole(cls, camera: CameraModel) -> "Window":
        """Return the window of all pixels of a camera."""
        return cls(0, camera.height, 0, camera.width)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.bottom - self.top, self.right - self.left

    @property
    def empty(self) -> bool:
        """There is no pixel in it."""
        return min(self.shape) <= 0

    @property
    def slices(self) -> tuple[slice, slice]:
        """The rows and columns, to index a picture."""
        return slice(self.top, self.bottom), slice(self.left, self.right)
