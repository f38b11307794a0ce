"""The calibrated sensor: a camera and a laser sheet, with what is not known of them."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, frozen
from calib.camera import PARAMETERS, CameraModel
from calib.plane import LightPlane

SENSOR_PARAMETERS = (*PARAMETERS, "a", "b", "c", "d")


@dataclass(frozen=True, slots=True, eq=False)
class LaserSensor:
    """What turns a stripe's pixels into points on the sheet.

    Attributes
    ----------
    camera, plane
        The two parts, in the camera frame.
    covariance
        Shape (13, 13), joint, in the order of `SENSOR_PARAMETERS`.
    """

    camera: CameraModel
    plane: LightPlane
    covariance: FloatArray

    def __post_init__(self) -> None:
        size = (len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS))
        object.__setattr__(self, "covariance", frozen(self.covariance, size, "covariance"))

    @classmethod
    def exact(cls, camera: CameraModel, plane: LightPlane) -> "LaserSensor":
        """Make a sensor without any doubt, as simulations have it."""
        return cls(camera, plane, np.zeros((len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS))))

    def locate(self, pixels_px: FloatArray) -> FloatArray:
        """Return the points on the sheet, in the camera frame and mm, that pixels show.

        Parameters
        ----------
        pixels_px
            Shape (N, 2).

        Returns
        -------
        points_in_cam_mm
            Shape (N, 3); NaN where a ray does not meet the sheet in front of the camera.
        """
        return self.plane.intersect(self.camera.rays(pixels_px))

    def location_jacobians(self, pixels_px: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what the points of `locate` owe to pixels and sensor; `locate_with_jacobians`."""
        _, by_pixel, by_sensor = self.locate_with_jacobians(pixels_px)
        return by_pixel, by_sensor

    def locate_with_jacobians(
        self, pixels_px: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        r"""Return the points of `locate`, and what they owe to the pixels and to the sensor.

        Parameters
        ----------
        pixels_px
            Shape (N, 2).

        Returns
        -------
        points_in_cam_mm
            Shape (N, 3).
        by_pixel
            d(point)/d(pixel), mm/px, shape (N, 3, 2).
        by_sensor
            d(point)/d(parameters) at a fixed pixel, shape (N, 3, 13), in the order of
            `SENSOR_PARAMETERS`.
        Rows are NaN where a ray does not meet the sheet in front of the camera.

        Notes
        -----
        With the ray :math:`\rho` and the normal n, the point is
        :math:`X = -d \rho / (n \cdot \rho)`, hence

        .. math:: \partial X / \partial \rho = -\frac{d}{n \cdot \rho}
                  (I - \frac{\rho n^T}{n \cdot \rho}), \quad
                  \partial X / \partial n = d \frac{\rho \rho^T}{(n \cdot \rho)^2}, \quad
                  \partial X / \partial d = -\frac{\rho}{n \cdot \rho}
        """
        rays, ray_by_pixel, ray_by_camera = self.camera.rays_with_jacobians(pixels_px)
        points = self.plane.intersect(rays)
        missed = np.isnan(points).any(axis=1)
        normal, offset = self.plane.normal_in_cam, self.plane.offset_mm
        along = np.where(missed, np.nan, rays @ normal)[:, None, None]
        column = rays[:, :, None]
        by_ray = -offset / along * (np.eye(3) - column * normal / along)
        by_normal = offset * column * rays[:, None, :] / along**2
        by_plane = np.concatenate([by_normal, -column / along], axis=2)
        by_sensor = np.concatenate([by_ray @ ray_by_camera, by_plane], axis=2)
        return points, by_ray @ ray_by_pixel, by_sensor

    def location_covariance(
        self,
        pixels_px: FloatArray,
        normal: FloatArray | None = None,
        sigma_px: FloatArray | float = 0.0,
    ) -> FloatArray:
        """Return the covariance of each located point, in the camera frame.

        Parameters
        ----------
        pixels_px
            Shape (N, 2).
        normal
            Shape (N, 2), unit: the picture direction along which the pixel is uncertain, as
            across a stripe. Without it the pixel is equally uncertain along u and v.
        sigma_px
            Scalar or shape (N,), standard deviation of the pixel along `normal`, or along each of
            u and v. At its 0 only the sensor's own doubt counts.

        Returns
        -------
        covariance_mm2
            Shape (N, 3, 3). The sensor's part is common to all points of one sensor and does not
            average out over them; use `location_jacobians` where that matters.
        """
        by_pixel, by_sensor = self.location_jacobians(pixels_px)
        own = by_sensor @ self.covariance @ by_sensor.transpose(0, 2, 1)
        if normal is not None:
            by_pixel = by_pixel @ normal[:, :, None]
        noise = by_pixel @ by_pixel.transpose(0, 2, 1)
        variance = np.broadcast_to(np.square(sigma_px), (len(pixels_px),))
        return np.asarray(own + variance[:, None, None] * noise)

    def sigma_on_sheet(
        self,
        pixels_px: FloatArray,
        normal: FloatArray | None = None,
        sigma_px: FloatArray | float = 0.0,
    ) -> FloatArray:
        """Return one standard deviation of each located point, mm, shape (N,).

        It is the root of the largest eigenvalue of `location_covariance`, whose parameters it
        takes: the uncertainty along the worst direction.
        """
        covariance = self.location_covariance(pixels_px, normal, sigma_px)
        located = np.isfinite(covariance).all(axis=(1, 2))
        worst = np.full(len(covariance), np.nan)
        # Rounding may leave a zero eigenvalue a little negative.
        worst[located] = np.linalg.eigvalsh(covariance[located])[:, -1].clip(min=0.0)
        return np.asarray(np.sqrt(worst))
