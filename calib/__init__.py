"""From pictures of a target to a light plane, with uncertainty.  Pure mathematics, lengths in mm.

Letters, frames, units and signs are in ``conventions.md`` beside this file.
"""

from calib.arrays import BoolArray, FloatArray, IntArray, Picture, frozen, read_only
from calib.bound import cramer_rao_bound
from calib.calibrate import calibrate, calibrate_camera
from calib.calibration import (
    Calibration,
    CameraCalibration,
    CameraRole,
    Method,
    SolvedPoints,
    SolvedView,
    SolveReport,
    Termination,
)
from calib.camera import PARAMETERS, CameraModel
from calib.compare import pixel_grid, sheet_difference_mm
from calib.errors import (
    CalibError,
    CameraMismatch,
    Degenerate,
    NotConverged,
    StripeNotFound,
    TargetNotFound,
    TargetSpecInvalid,
    TooFewViews,
)
from calib.noise import PixelNoise
from calib.observe import observe_target
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.sensor import SENSOR_PARAMETERS, LaserSensor
from calib.stripe import kernel_of, locate_stripe
from calib.target import Target
from calib.views import Cause, StripePoints, TargetPoints, View

__all__ = [
    "PARAMETERS",
    "SENSOR_PARAMETERS",
    "BoolArray",
    "CalibError",
    "Calibration",
    "CameraCalibration",
    "CameraMismatch",
    "CameraModel",
    "CameraRole",
    "Cause",
    "Degenerate",
    "FloatArray",
    "IntArray",
    "LaserSensor",
    "LightPlane",
    "Method",
    "NotConverged",
    "Picture",
    "PixelNoise",
    "RigidTransform",
    "SolveReport",
    "SolvedPoints",
    "SolvedView",
    "StripeNotFound",
    "StripePoints",
    "Target",
    "TargetNotFound",
    "TargetPoints",
    "TargetSpecInvalid",
    "Termination",
    "TooFewViews",
    "View",
    "calibrate",
    "calibrate_camera",
    "cramer_rao_bound",
    "frozen",
    "kernel_of",
    "locate_stripe",
    "observe_target",
    "read_only",
    "pixel_grid",
    "sheet_difference_mm",
]
