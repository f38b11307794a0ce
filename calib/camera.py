"""The camera: a pinhole with OpenCV's five distortion coefficients."""

from dataclasses import dataclass

import cv2
import numpy as np

from calib.arrays import FloatArray, frozen

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True, slots=True, eq=False)
class CameraModel:
    """Intrinsics of one camera at one resolution; pixel (0, 0) is the top-left pixel's centre.

    Attributes
    ----------
    fx, fy, cx, cy
        Focal lengths and principal point, px.
    k1, k2, p1, p2, k3
        Distortion as OpenCV means it; unused ones are 0.
    width, height
        Size of the picture, px.
    covariance
        Shape (9, 9), in the order of `PARAMETERS`; rows of parameters that were held are zero.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    k1: float
    k2: float
    p1: float
    p2: float
    k3: float
    width: int
    height: int
    covariance: FloatArray

    def __post_init__(self) -> None:
        frozen(self.parameters, (len(PARAMETERS),), "camera parameters")
        if not (self.fx > 0.0 and self.fy > 0.0):
            raise ValueError(f"focal lengths must be positive, got {self.fx}, {self.fy}")
        if not (self.width > 0 and self.height > 0):
            raise ValueError(f"picture size must be positive, got {self.width} x {self.height}")
        size = (len(PARAMETERS), len(PARAMETERS))
        object.__setattr__(self, "covariance", frozen(self.covariance, size, "covariance"))

    @classmethod
    def from_parameters(
        cls,
        parameters: FloatArray,
        *,
        width: int,
        height: int,
        covariance: FloatArray | None = None,
    ) -> "CameraModel":
        """Make a camera of nine numbers in the order of `PARAMETERS`; no covariance means exact."""
        if covariance is None:
            covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
        fx, fy, cx, cy, k1, k2, p1, p2, k3 = (float(value) for value in parameters)
        return cls(fx, fy, cx, cy, k1, k2, p1, p2, k3, width, height, covariance)

    @property
    def parameters(self) -> FloatArray:
        """Shape (9,), in the order of `PARAMETERS`."""
        return np.array([getattr(self, name) for name in PARAMETERS], dtype=np.float64)

    @property
    def matrix(self) -> FloatArray:
        """K, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> FloatArray:
        """(k1, k2, p1, p2, k3), shape (5,)."""
        return self.parameters[4:]

    def project(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Project points, shape (N, 3), to pixels, shape (N, 2)."""
        x, y = (points_in_cam_mm[:, :2] / points_in_cam_mm[:, 2:]).T
        r2 = x * x + y * y
        radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        x_seen = x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x)
        y_seen = y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y
        return np.column_stack([self.fx * x_seen + self.cx, self.fy * y_seen + self.cy])

    def rays(self, pixels_px: FloatArray) -> FloatArray:
        """Return rays (x, y, 1) in the camera frame, shape (N, 3), of pixels, shape (N, 2)."""
        if len(pixels_px) == 0:
            return np.empty((0, 3))
        normalised = cv2.undistortPoints(
            np.ascontiguousarray(pixels_px, dtype=np.float64).reshape(-1, 1, 2),
            self.matrix,
            self.distortion,
            criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 50, 1e-12),
        ).reshape(-1, 2)
        return np.column_stack([normalised, np.ones(len(normalised))])
