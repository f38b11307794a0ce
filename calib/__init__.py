"""From pictures of a target to a light plane, with uncertainty.  Pure mathematics, lengths in mm.

Letters, frames, units and signs are in ``conventions.md`` beside this file.
"""

from calib.arrays import BoolArray, FloatArray, IntArray, Picture, frozen, read_only
from calib.camera import PARAMETERS, CameraModel
from calib.errors import (
    CalibError,
    Degenerate,
    NotConverged,
    StripeNotFound,
    TargetNotFound,
    TargetSpecInvalid,
    TooFewViews,
)
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.sensor import SENSOR_PARAMETERS, LaserSensor
from calib.target import Target
from calib.views import Cause, StripePoints, TargetPoints, View

__all__ = [
    "PARAMETERS",
    "SENSOR_PARAMETERS",
    "BoolArray",
    "CalibError",
    "CameraModel",
    "Cause",
    "Degenerate",
    "FloatArray",
    "IntArray",
    "LaserSensor",
    "LightPlane",
    "NotConverged",
    "Picture",
    "RigidTransform",
    "StripeNotFound",
    "StripePoints",
    "Target",
    "TargetNotFound",
    "TargetPoints",
    "TargetSpecInvalid",
    "TooFewViews",
    "View",
    "frozen",
    "read_only",
]
