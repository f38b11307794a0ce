"""A wheel profile as values: what was measured, or read from a file."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray, frozen, read_only
from measure.gauging.levels import TAPE_D_MM
from measure.quantities import Quantity
from measure.reference import ReferenceProfile


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
    seen_by
        Shape (N,): bit k is set where sensor k of the rig has points; None where one saw all.

    Raises
    ------
    ValueError
        If the lengths differ, a number is not finite, or a sigma is negative.
    """

    d_mm: FloatArray
    h_mm: FloatArray
    sigma_mm: FloatArray
    seen_by: IntArray | None = None

    def __post_init__(self) -> None:
        for name in ("d_mm", "h_mm", "sigma_mm"):
            object.__setattr__(self, name, frozen(getattr(self, name), (len(self.d_mm),), name))
        if not (self.sigma_mm >= 0.0).all():
            raise ValueError(f"sigma_mm must not be negative, got {self.sigma_mm.min()}")
        if self.seen_by is not None:
            seen_by = read_only(np.asarray(self.seen_by, dtype=np.int64))
            if seen_by.shape != (len(self),):
                raise ValueError(f"seen_by must have shape ({len(self)},), got {seen_by.shape}")
            object.__setattr__(self, "seen_by", seen_by)

    def __len__(self) -> int:
        return len(self.d_mm)

    @property
    def points_mm(self) -> FloatArray:
        """(d, h), shape (N, 2)."""
        return np.column_stack([self.d_mm, self.h_mm])

    def aligned(self, tip_mm: float, reference: ReferenceProfile) -> "Profile":
        """Return the profile raised so that its tip, now at a height, is as high as a reference's.

        The tip does not wear: what is then missing below the reference is wear.
        """
        rise = reference.nominal[Quantity.FLANGE_HEIGHT] - tip_mm
        return Profile(self.d_mm, self.h_mm + rise, self.sigma_mm, self.seen_by)

    def wear_mm(self, reference: ReferenceProfile) -> FloatArray:
        """Return reference minus height from the tip to the field side, aligned as the profile is.

        Returns
        -------
        wear_mm
            Shape (N,); NaN behind the tip, where nothing wears, and where the reference ends.
        """
        wear = reference.height_mm(self.d_mm - TAPE_D_MM) - self.h_mm
        tip_d = self.d_mm[int(np.argmax(self.h_mm))] if len(self) else 0.0
        return np.where(self.d_mm >= tip_d, wear, np.nan)
