"""Planes of laser light and the points where camera rays meet them."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from calib.arrays import FloatArray, frozen


@dataclass(frozen=True, slots=True, eq=False)
class LightPlane:
    """One laser sheet, ``a x + b y + c z + d = 0`` in the camera frame, with ``d >= 0``.

    Attributes
    ----------
    normal_in_cam
        (a, b, c): shape (3,), unit length; it points from the sheet towards the camera centre.
    offset_mm
        d: distance of the camera centre from the sheet.

    Raises
    ------
    ValueError
        If the normal is not a unit 3-vector, or the offset is negative or not finite.
    """

    normal_in_cam: FloatArray
    offset_mm: float

    def __post_init__(self) -> None:
        normal = frozen(self.normal_in_cam, (3,), "normal_in_cam")
        if not abs(np.linalg.norm(normal) - 1.0) <= 1e-9:
            raise ValueError(f"normal_in_cam must be a unit vector, got {self.normal_in_cam!r}")
        if not 0.0 <= self.offset_mm < np.inf:
            raise ValueError(f"offset_mm must be finite and not negative, got {self.offset_mm!r}")
        object.__setattr__(self, "normal_in_cam", normal)
        object.__setattr__(self, "offset_mm", float(self.offset_mm))

    @classmethod
    def from_coefficients(cls, coefficients: ArrayLike) -> Self:
        """Make the plane of (a, b, c, d) at any scale and sign.

        Raises
        ------
        ValueError
            If a, b and c are all zero or an entry is not finite.

        Examples
        --------
        >>> LightPlane.from_coefficients([0.0, 0.0, 2.0, -1000.0]).coefficients.tolist()
        [-0.0, -0.0, -1.0, 500.0]
        """
        values = frozen(coefficients, (4,), "coefficients")
        length = float(np.linalg.norm(values[:3]))
        if not length > 0.0:
            raise ValueError(f"a, b and c must not all be zero, got {values!r}")
        scale = (-1.0 if values[3] < 0.0 else 1.0) / length
        return cls(values[:3] * scale, abs(float(values[3]) * scale))

    @property
    def coefficients(self) -> FloatArray:
        """(a, b, c, d), shape (4,)."""
        return np.append(self.normal_in_cam, self.offset_mm)

    def distance_mm(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Signed distance of points, shape (N, 3); positive on the camera's side."""
        return points_in_cam_mm @ self.normal_in_cam + self.offset_mm

    def intersect(self, rays_in_cam: FloatArray) -> FloatArray:
        """Return where rays from the camera centre meet the sheet, in mm.

        Parameters
        ----------
        rays_in_cam
            Shape (N, 3), any length.

        Returns
        -------
        points_in_cam_mm
            Shape (N, 3); a row is NaN where the ray runs along the sheet or meets it behind the
            camera.

        Examples
        --------
        >>> sheet = LightPlane.from_coefficients([0.0, 0.0, 1.0, -500.0])
        >>> sheet.intersect(np.array([[0.1, 0.0, 1.0]])).tolist()
        [[50.0, 0.0, 500.0]]
        """
        along_normal = rays_in_cam @ self.normal_in_cam
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = -self.offset_mm / along_normal
        in_front = np.isfinite(depth) & (depth > 0.0)
        return np.asarray(np.where(in_front, depth, np.nan)[:, None] * rays_in_cam)
