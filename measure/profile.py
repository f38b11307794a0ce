"""A wheel profile as values: what was measured, or read from a file."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, frozen


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """A measured profile, from the flange back to the field side.

    Attributes
    ----------
    d_mm
        Shape (N,), distance from the flange back.
    h_mm
        Shape (N,), height; of a measured wheel over the nominal tread, aligned at the tip.
    sigma_mm
        Shape (N,), standard deviation across the profile; zero where it is not known.

    Raises
    ------
    ValueError
        If the lengths differ, a number is not finite, or a sigma is negative.
    """

    d_mm: FloatArray
    h_mm: FloatArray
    sigma_mm: FloatArray

    def __post_init__(self) -> None:
        for name in ("d_mm", "h_mm", "sigma_mm"):
            object.__setattr__(self, name, frozen(getattr(self, name), (len(self.d_mm),), name))
        if not (self.sigma_mm >= 0.0).all():
            raise ValueError(f"sigma_mm must not be negative, got {self.sigma_mm.min()}")

    def __len__(self) -> int:
        return len(self.d_mm)

    @property
    def points_mm(self) -> FloatArray:
        """(d, h), shape (N, 2)."""
        return np.column_stack([self.d_mm, self.h_mm])
