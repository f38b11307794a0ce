"""Ways in which a sensor drifts after its calibration, and the pieces that shall show it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from calib import CameraModel, LaserSensor, LightPlane, RigidTransform, SheetFrame
from measure import Piece


@dataclass(frozen=True, slots=True)
class Drift:
    """One way to drift, by a size.

    Attributes
    ----------
    name, size, unit
        What it is called; its size in the unit.
    drifted
        Makes the sensor that has drifted by so many sizes.
    """

    name: str
    size: float
    unit: str
    drifted: Callable[[LaserSensor, float], LaserSensor]


def _plane_turned(axis: int, sensor: LaserSensor, sizes: float) -> LaserSensor:
    """Turn the sheet about one of its own directions through the middle of the field."""
    along = SheetFrame.of(sensor.plane).axes_in_cam[axis]
    about = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))[0]
    angle = np.radians(0.05) * sizes
    turn = RigidTransform.from_rotation_vector(along * angle, np.zeros(3)).rotation
    normal = turn @ sensor.plane.normal_in_cam
    plane = LightPlane.from_coefficients([*normal, -float(normal @ about)])
    return LaserSensor(sensor.camera, plane, sensor.covariance)


def _plane_moved(sensor: LaserSensor, sizes: float) -> LaserSensor:
    a, b, c, d = sensor.plane.coefficients
    plane = LightPlane.from_coefficients([a, b, c, d + 0.1 * sizes])
    return LaserSensor(sensor.camera, plane, sensor.covariance)


def _focal_length(sensor: LaserSensor, sizes: float) -> LaserSensor:
    parameters = sensor.camera.parameters.copy()
    parameters[:2] *= 1.0 + 1e-3 * sizes
    camera = CameraModel.from_parameters(
        parameters, width=sensor.camera.width, height=sensor.camera.height
    )
    return LaserSensor(camera, sensor.plane, sensor.covariance)


def _nothing(sensor: LaserSensor, sizes: float) -> LaserSensor:
    del sizes
    return sensor


NO_DRIFT = Drift("none", 0.0, "", _nothing)
DRIFTS = (
    NO_DRIFT,
    Drift("sheet turned, depth", 0.05, "deg", partial(_plane_turned, 0)),
    Drift("sheet turned, across", 0.05, "deg", partial(_plane_turned, 1)),
    Drift("sheet moved", 0.1, "mm", _plane_moved),
    Drift("focal length", 0.1, "%", _focal_length),
)


def profile_piece(size: float = 1.0) -> Piece:
    """Return a piece of flats and flanks of 45 degrees on two levels, 110 mm long at size 1."""
    x = np.array([0.0, 20.0, 30.0, 50.0, 60.0, 80.0, 90.0, 110.0])
    z = np.array([0.0, 0.0, 10.0, 10.0, 0.0, 0.0, 10.0, 10.0])
    corners = [[(size * a, size * b)] for a, b in zip(x, z, strict=True)]
    return Piece.from_corners(
        f"profile of {110.0 * size:g} mm", "", corners, u95_mm=0.003, held_u95_mm=0.01
    )


PIECES = (profile_piece(), profile_piece(2.0), Piece.step(20.0, width_mm=60.0, u95_mm=0.003))
"""What the bench tries."""
