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
