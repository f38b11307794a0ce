"""Pieces of a reference profile: the height z over the lateral place y, mm."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from calib import FloatArray, frozen


class Segment(Protocol):
    """A piece of the profile that ends at ``end_mm``; the piece before it says where it starts."""

    @property
    def end_mm(self) -> float:
        """Lateral place where the piece ends."""

    def height_mm(self, y_mm: FloatArray) -> FloatArray:
        """Height at lateral places."""


@dataclass(frozen=True, slots=True)
class Arc:
    """Upper (``side`` = 1) or lower (-1) half of a circle about (y, z)."""

    end_mm: float
    centre_mm: tuple[float, float]
    radius_mm: float
    side: int

    def height_mm(self, y_mm: FloatArray) -> FloatArray:
        """Height at lateral places; places beyond the circle by rounding count as its edge."""
        across = y_mm - self.centre_mm[0]
        drop = np.sqrt(np.maximum(self.radius_mm**2 - across**2, 0.0))
        return np.asarray(self.centre_mm[1] + self.side * drop)


@dataclass(frozen=True, slots=True)
class Line:
    """Straight line of a slope dz/dy through a point (y, z)."""

    end_mm: float
    through_mm: tuple[float, float]
    slope: float

    def height_mm(self, y_mm: FloatArray) -> FloatArray:
        """Height at lateral places."""
        return np.asarray(self.through_mm[1] + self.slope * (y_mm - self.through_mm[0]))


@dataclass(frozen=True, slots=True)
class Polynomial:
    """Polynomial in y, constant term first."""

    end_mm: float
    coefficients: tuple[float, ...]

    def height_mm(self, y_mm: FloatArray) -> FloatArray:
        """Height at lateral places."""
        return np.asarray(np.polynomial.polynomial.polyval(y_mm, self.coefficients))


@dataclass(frozen=True, slots=True, eq=False)
class Chords:
    """Straight chords between points of rising y."""

    y_mm: FloatArray
    z_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "y_mm", frozen(self.y_mm, (None,), "y_mm"))
        object.__setattr__(self, "z_mm", frozen(self.z_mm, self.y_mm.shape, "z_mm"))

    @property
    def end_mm(self) -> float:
        """Lateral place of the last point."""
        return float(self.y_mm[-1])

    def height_mm(self, y_mm: FloatArray) -> FloatArray:
        """Height at lateral places."""
        return np.interp(y_mm, self.y_mm, self.z_mm)
