"""The part of the picture in which a sensor measures, and how much of it dots have covered."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, read_only
from calib.compare import pixel_grid
from calib.sensor import LaserSensor

COLUMNS, ROWS = 8, 6
"""Cells of the picture: two to four dots of a board wide, as fine as lens models bend."""
_STEP_PX = 32


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """How many dots fell on each cell of the picture.

    Attributes
    ----------
    dots
        Shape (`ROWS`, `COLUMNS`).
    wanted
        Shape (`ROWS`, `COLUMNS`), the cells in which the sensor measures.
    """

    dots: IntArray
    wanted: BoolArray

    def __post_init__(self) -> None:
        if not self.dots.shape == self.wanted.shape == (ROWS, COLUMNS):
            raise ValueError(f"cells of shapes {self.dots.shape} and {self.wanted.shape}")
        object.__setattr__(self, "dots", read_only(self.dots))
        object.__setattr__(self, "wanted", read_only(self.wanted))

    @classmethod
    def of(cls, dots_px: FloatArray, field_px: FloatArray, *, width: int, height: int) -> Self:
        """Count dots, shape (N, 2), in a picture; `field_px`, shape (M, 2), is where it matters."""
        size_px = (width, height)
        return cls(_counts(dots_px, size_px), _counts(field_px, size_px) > 0)

    @property
    def missing(self) -> BoolArray:
        """The cells in which the sensor measures and no dot has been seen."""
        return np.asarray(self.wanted & (self.dots == 0))

    @property
    def share(self) -> float:
        """Part of the wanted cells that have a dot, 0 to 1; 0 where none is wanted."""
        return 1.0 - float(self.missing.sum() / self.wanted.sum()) if self.wanted.any() else 0.0

    def gain(self, dots_px: FloatArray, *, width: int, height: int) -> int:
        """Return in how many missing cells dots, shape (N, 2), would fall."""
        return int((self.missing & (_counts(dots_px, (width, height)) > 0)).sum())


def field_of(sensor: LaserSensor, depths_mm: tuple[float, float]) -> FloatArray:
    """Return pixels, shape (N, 2), that see the sheet between two depths, or all that see it."""
    pixels_px = pixel_grid(sensor.camera.width, sensor.camera.height, _STEP_PX)
    depth_mm = sensor.locate(pixels_px)[:, 2]
    seen = np.isfinite(depth_mm)
    inside = seen & (depth_mm >= depths_mm[0]) & (depth_mm <= depths_mm[1])
    return np.asarray(pixels_px[inside if inside.any() else seen])


def _counts(pixels_px: FloatArray, size_px: tuple[int, int]) -> IntArray:
    width, height = size_px
    edges = (np.linspace(-0.5, height - 0.5, ROWS + 1), np.linspace(-0.5, width - 0.5, COLUMNS + 1))
    return np.histogram2d(pixels_px[:, 1], pixels_px[:, 0], bins=edges)[0].astype(np.int64)
