"""The camera: a pinhole with OpenCV's five distortion coefficients."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, frozen
from calib.lens import normalised_of, picture_by_camera, picture_of, picture_slope

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
        return picture_of(points_in_cam_mm[:, :2] / points_in_cam_mm[:, 2:], self.parameters)

    def project_with_jacobians(
        self, points_in_cam_mm: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Project points, with what the pixels owe to the points and to the camera.

        Parameters
        ----------
        points_in_cam_mm
            Shape (N, 3), in front of the camera.

        Returns
        -------
        pixels_px
            Shape (N, 2).
        by_point
            d(pixel)/d(point), px/mm, shape (N, 2, 3).
        by_camera
            d(pixel)/d(camera), shape (N, 2, 9), in the order of `PARAMETERS`.
        """
        parameters = self.parameters
        depth = points_in_cam_mm[:, 2]
        normalised = points_in_cam_mm[:, :2] / depth[:, None]
        by_point = picture_slope(normalised, parameters) @ normalised_by_point(normalised, depth)
        pixels = picture_of(normalised, parameters)
        return pixels, by_point, picture_by_camera(normalised, parameters)

    def rays(self, pixels_px: FloatArray) -> FloatArray:
        """Return rays (x, y, 1) in the camera frame of pixels.

        Parameters
        ----------
        pixels_px
            Shape (N, 2).

        Returns
        -------
        rays_in_cam
            Shape (N, 3); a row is NaN where the lens model has no inverse, far outside any
            sensible picture.
        """
        normalised = normalised_of(np.asarray(pixels_px, dtype=np.float64), self.parameters)
        return np.column_stack([normalised, np.ones(len(normalised))])

    def rays_with_jacobians(
        self, pixels_px: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return rays, with what they owe to the pixels and to the camera.

        Parameters
        ----------
        pixels_px
            Shape (N, 2).

        Returns
        -------
        rays_in_cam
            (x, y, 1), shape (N, 3); NaN as in `rays`.
        by_pixel
            d(ray)/d(pixel), shape (N, 3, 2).
        by_camera
            d(ray)/d(camera) at a fixed pixel, shape (N, 3, 9).

        Notes
        -----
        With p = f(x, camera) the ray of a fixed pixel moves by ``-(df/dx)^-1 df/dcamera``.
        """
        rays = self.rays(pixels_px)
        slope = picture_slope(rays[:, :2], self.parameters)
        # A ray that does not exist has no slope; its rows come out NaN instead of singular.
        gone = np.isnan(slope[:, 0, 0])
        inverse = np.linalg.inv(np.where(gone[:, None, None], np.eye(2), slope))
        inverse[gone] = np.nan
        by_pixel = np.zeros((len(rays), 3, 2))
        by_pixel[:, :2] = inverse
        return rays, by_pixel, -by_pixel @ picture_by_camera(rays[:, :2], self.parameters)


def normalised_by_point(normalised: FloatArray, depth_mm: FloatArray) -> FloatArray:
    """Return d(x/z, y/z)/d(point), 1/mm, shape (N, 2, 3)."""
    jacobian = np.zeros((len(normalised), 2, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0 / depth_mm
    jacobian[:, :, 2] = -normalised / depth_mm[:, None]
    return jacobian
