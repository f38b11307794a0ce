"""What is seen in one picture of a target: its points and the stripe across it."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from calib.arrays import BoolArray, FloatArray, IntArray, frozen, read_only


class Cause(StrEnum):
    """Why a point is doubtful or was left out; ``NONE`` is a point as it should be."""

    NONE = ""
    SATURATED = "saturated"
    CROSSED = "crossed by the stripe"
    GLARE = "glare"
    STRAY_LIGHT = "stray light"
    OFF_LINE = "off the line"
    OFF_BOARD = "off the board"
    OUTLIER = "outlier"


@dataclass(frozen=True, slots=True, eq=False)
class TargetPoints:
    """Dots or corners seen in one picture, numbered.

    Attributes
    ----------
    row, col
        Shape (N,), the place on the target.
    centre_px
        Shape (N, 2), observed.
    sigma_px
        Shape (N, 2), standard deviation along u and v.
    cause
        N entries: why a point is doubtful as seen in the picture (it is still used, with its
        sigma); ``Cause.NONE`` for most.
    """

    row: IntArray
    col: IntArray
    centre_px: FloatArray
    sigma_px: FloatArray
    cause: tuple[Cause, ...]

    def __post_init__(self) -> None:
        count = len(self.row)
        object.__setattr__(self, "row", read_only(np.asarray(self.row, dtype=np.int64)))
        object.__setattr__(self, "col", read_only(np.asarray(self.col, dtype=np.int64)))
        object.__setattr__(self, "centre_px", frozen(self.centre_px, (count, 2), "centre_px"))
        object.__setattr__(self, "sigma_px", frozen(self.sigma_px, (count, 2), "sigma_px"))
        if not (len(self.col) == count and len(self.cause) == count):
            raise ValueError(f"{count} rows, {len(self.col)} cols, {len(self.cause)} causes")
        if not (self.sigma_px > 0.0).all():
            raise ValueError("sigma_px must be positive")

    def __len__(self) -> int:
        return len(self.row)

    def points_mm(self, pitch_mm: float) -> FloatArray:
        """Return the same points on the target, TCF, shape (N, 3)."""
        return np.column_stack([self.col, self.row, np.zeros(len(self))]) * pitch_mm


@dataclass(frozen=True, slots=True, eq=False)
class StripePoints:
    """Centres of the laser stripe in one picture.

    Attributes
    ----------
    centre_px
        Shape (N, 2), observed.
    normal
        Shape (N, 2), unit, across the stripe.
    sigma_px
        Shape (N,), standard deviation along the normal. Along the stripe nothing is known.
    width_px
        Shape (N,), standard deviation of the stripe's profile (sigma_w of Eq. 9).
    peak
        Shape (N,), height over the background, counts.
    saturated
        Shape (N,), the sensor clipped there.
    cause
        N entries: why a point is doubtful as seen in the picture.
    """

    centre_px: FloatArray
    normal: FloatArray
    sigma_px: FloatArray
    width_px: FloatArray
    peak: FloatArray
    saturated: BoolArray
    cause: tuple[Cause, ...]

    def __post_init__(self) -> None:
        count = len(self.centre_px)
        for name, shape in (
            ("centre_px", (count, 2)),
            ("normal", (count, 2)),
            ("sigma_px", (count,)),
            ("width_px", (count,)),
            ("peak", (count,)),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), shape, name))
        object.__setattr__(self, "saturated", read_only(np.asarray(self.saturated, dtype=bool)))
        if not (len(self.saturated) == count and len(self.cause) == count):
            raise ValueError(
                f"{count} centres, {len(self.saturated)} flags, {len(self.cause)} causes"
            )
        if not (self.sigma_px > 0.0).all():
            raise ValueError("sigma_px must be positive")

    def __len__(self) -> int:
        return len(self.centre_px)

    def select(self, keep: BoolArray | NDArray[np.int64]) -> "StripePoints":
        """Return the points that a mask or an index array picks."""
        index = np.flatnonzero(keep) if keep.dtype == bool else keep
        return StripePoints(
            centre_px=self.centre_px[index],
            normal=self.normal[index],
            sigma_px=self.sigma_px[index],
            width_px=self.width_px[index],
            peak=self.peak[index],
            saturated=self.saturated[index],
            cause=tuple(map(self.cause.__getitem__, index.tolist())),
        )


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One picture of the target: its name, the points found, the stripe across the board.

    `stripe` is None where the picture shows no stripe; such a picture still serves the camera.
    `rivals` are other lines across the board that the picture alone cannot tell from the stripe.
    `dot_radius` is that of the dots as seen, in pitches; None of corners, or without a picture.
    """

    name: str
    points: TargetPoints
    stripe: StripePoints | None
    rivals: tuple[StripePoints, ...] = ()
    dot_radius: float | None = None
