"""Two coordinates on the light sheet."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import FloatArray, frozen
from calib.plane import LightPlane

# The camera's x axis is taken unless it stands nearly upright on the sheet.
_LEAST_SINE = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class SheetFrame:
    """A frame of the sheet: (s, t) in mm stands for ``origin + s axes[0] + t axes[1]``.

    Attributes
    ----------
    origin_in_cam_mm
        Shape (3,).
    axes_in_cam
        Shape (2, 3), unit, square to each other. With the third axis pointing away from the
        camera they are right-handed, as on a target.
    """

    origin_in_cam_mm: FloatArray
    axes_in_cam: FloatArray

    def __post_init__(self) -> None:
        axes = frozen(self.axes_in_cam, (2, 3), "axes_in_cam")
        if not np.abs(axes @ axes.T - np.eye(2)).max() <= 1e-9:
            raise ValueError(f"axes_in_cam must be unit and square to each other, got {axes!r}")
        object.__setattr__(self, "axes_in_cam", axes)
        origin = frozen(self.origin_in_cam_mm, (3,), "origin_in_cam_mm")
        object.__setattr__(self, "origin_in_cam_mm", origin)

    @classmethod
    def of(cls, plane: LightPlane) -> Self:
        """Make the frame that a plane alone decides.

        Its origin is the foot of the perpendicular from the camera's centre. Its first axis is
        the camera's x axis seen along the sheet's normal (the camera's y axis where x stands
        nearly upright on the sheet); its second runs down the picture.
        """
        normal = plane.normal_in_cam
        first, second = np.eye(3)[:2]
        along = first if np.linalg.norm(np.cross(first, normal)) > _LEAST_SINE else second
        along = along - (along @ normal) * normal
        along = along / np.linalg.norm(along)
        return cls(-plane.offset_mm * normal, np.stack([along, np.cross(along, normal)]))

    def coordinates(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return (s, t) of points on the sheet, shape (..., 3), as shape (..., 2)."""
        return np.asarray((points_in_cam_mm - self.origin_in_cam_mm) @ self.axes_in_cam.T)

    def points(self, coordinates_mm: FloatArray) -> FloatArray:
        """Return the points in the camera frame, shape (..., 3), of (s, t), shape (..., 2)."""
        return np.asarray(self.origin_in_cam_mm + coordinates_mm @ self.axes_in_cam)

    def slope_of(self, direction_in_cam: FloatArray) -> FloatArray:
        """Return (p, q) of a direction that is (p, q, 1) in this frame, up to length, shape (2,).

        Raises
        ------
        ValueError
            If the direction lies in the sheet.
        """
        upright = float(np.cross(self.axes_in_cam[0], self.axes_in_cam[1]) @ direction_in_cam)
        if not abs(upright) > 1e-6 * np.linalg.norm(direction_in_cam):
            raise ValueError(f"direction must leave the sheet, got {direction_in_cam!r}")
        return np.asarray(self.axes_in_cam @ direction_in_cam / upright)
