"""The sensor of the paper as it would be built, and where it stands beside the track."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib import CameraModel, FloatArray, LaserSensor, LightPlane, RigidTransform

WIDTH_PX = 2048
HEIGHT_PX = 1088
WHEEL_RADIUS_MM = 420.0
"""Nominal radius of the wheels the mounting is made for, at the tape circle."""

_PARAMETERS = (2315.8488, 2312.4282, 1004.8597, 555.3317, -0.1267, 0.1204, 0.0, 0.0, 0.0)
# The axis of the camera meets the sheet 486 mm away (a field of 430 x 230 mm) at 35 degrees;
# the small first coefficient is the roll no real mounting is free of.
_PLANE = (0.0151, 0.8186, -0.5742, 279.06)
_BASELINE_MM = 340.0

Side = Literal["left", "right"]
Place = Literal["only", "inner", "outer"]


@dataclass(frozen=True, slots=True)
class _Stand:
    """How a sensor stands before a wheel.

    Attributes
    ----------
    tilt_rad
        Of the camera from the wheel's radius, within the sheet, to the flange back's side.
    below_horizon_rad
        Where round the wheel the sheet meets the tread.
    aim_lateral_mm
        Where the camera's axis meets the tread's height, from the tape circle.
    """

    tilt_rad: float
    below_horizon_rad: float
    aim_lateral_mm: float


_STANDS: dict[Place, _Stand] = {
    # In the section of the wheel the back face stands at 0 and the flange face at 20 degrees to
    # the radius. Only a sensor that looks in from between the two sees both; 15 degrees within
    # the sheet put its camera near 5 and 10 degrees, and its laser near 9 and 12, at those faces.
    "only": _Stand(math.radians(15.0), math.radians(30.0), -15.0),
    # Camera and laser at 31 and 41 degrees on the back face. The flange's shadow on the tread
    # ends 48 mm from the back: the tape circle, at 70, is seen.
    "inner": _Stand(math.radians(45.0), math.radians(45.0), -40.0),
    # Looks down the flange face, at 43 degrees to it, and over the tip, to 4 mm from the back.
    "outer": _Stand(math.radians(-28.0), math.radians(30.0), -10.0),
}
# With two, cameras and lasers stand below the top of the rail, out of the vehicles' gauge, and no
# line of sight comes nearer than 10 mm to the rail's head.


def paper_sensor() -> LaserSensor:
    """Return the sensor of the paper, exactly known: its camera, and a sheet 35 degrees off."""
    camera = CameraModel.from_parameters(np.array(_PARAMETERS), width=WIDTH_PX, height=HEIGHT_PX)
    return LaserSensor.exact(camera, LightPlane.from_coefficients(_PLANE))


def projector_in_cam_mm(sensor: LaserSensor) -> FloatArray:
    """Return where the fan of the laser starts: the place in the sheet above the camera, (3,)."""
    above = np.array([0.0, -_BASELINE_MM, 0.0])
    distance_mm = float(sensor.plane.distance_mm(above[None])[0])
    return above - distance_mm * sensor.plane.normal_in_cam


def trackside_mounting(
    side: Side, place: Place = "only", *, below_horizon_rad: float | None = None
) -> RigidTransform:
    """Return rig_from_camera of the paper's sensor beside the track, looking at a wheel.

    The sheet contains the axle of a wheel of nominal radius that stands at x = 0: there the
    section is radial. It meets the tread below the horizon, on the side of +x on the left of
    the train. The right side is its mirror picture across the track; as rig y points to the field
    on both sides, that is the same sensor at -x.

    Parameters
    ----------
    side
        Of the train.
    place
        The only sensor of a wheel stands between the rails, 30 degrees below the horizon. Of two,
        the inner one stands there as well, at 45 degrees; the outer one on the field side, at 30.
    below_horizon_rad
        Another angle below the horizon; the same for both makes their sheets coplanar.

    Raises
    ------
    ValueError
        If `side` or `place` is none of these, or the angle is not within a right one.
    """
    if side not in ("left", "right"):
        raise ValueError(f"side must be left or right, got {side!r}")
    if place not in _STANDS:
        raise ValueError(f"place must be one of {', '.join(_STANDS)}, got {place!r}")
    stand = _STANDS[place]
    below_rad = stand.below_horizon_rad if below_horizon_rad is None else below_horizon_rad
    if not abs(below_rad) < math.pi / 2.0:
        raise ValueError(f"below_horizon_rad must be within a right angle, got {below_rad}")
    sensor = paper_sensor()
    ahead = 1.0 if side == "left" else -1.0
    outward_in_rig = np.array([ahead * math.cos(below_rad), 0.0, -math.sin(below_rad)])
    axle_in_rig = np.array([0.0, 1.0, 0.0])
    aim_in_rig_mm = (
        np.array([0.0, stand.aim_lateral_mm, WHEEL_RADIUS_MM]) + WHEEL_RADIUS_MM * outward_in_rig
    )

    axle_in_cam, outward_in_cam = _section_axes_in_cam(sensor.plane, ahead, stand.tilt_rad)
    rotation = _frame(axle_in_rig, outward_in_rig) @ _frame(axle_in_cam, outward_in_cam).T
    aim_in_cam_mm = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))[0]
    return RigidTransform(rotation, aim_in_rig_mm - rotation @ aim_in_cam_mm)


def _section_axes_in_cam(
    plane: LightPlane, ahead: float, tilt_rad: float
) -> tuple[FloatArray, FloatArray]:
    """Return the directions of the axle and outward of the wheel, both in the sheet."""
    normal = plane.normal_in_cam
    to_camera = np.array([0.0, 0.0, -1.0])
    to_camera_in_sheet = to_camera - (to_camera @ normal) * normal
    to_camera_in_sheet /= np.linalg.norm(to_camera_in_sheet)
    # The sheet is seen from the side its normal points to; with the axle to the field and the
    # wheel outward, that side is told by their cross product.
    across = ahead * np.cross(to_camera_in_sheet, normal)
    axle = math.cos(tilt_rad) * across - math.sin(tilt_rad) * to_camera_in_sheet
    outward = math.cos(tilt_rad) * to_camera_in_sheet + math.sin(tilt_rad) * across
    return axle, outward


def _frame(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.column_stack([first, second, np.cross(first, second)])
