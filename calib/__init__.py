"""From pictures of a target to a light plane, with uncertainty.  Pure mathematics, lengths in mm.

Letters, frames, units and signs are in ``conventions.md`` beside this file. Values and geometry
stand here; ``seeing`` turns pixels into points, ``solving`` points into a sensor, ``judging`` tells
how good the sensor is, ``planning`` which pictures would make it better.
"""

from calib.arrays import BoolArray, FloatArray, IntArray, Picture, frozen, read_only
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
from calib.compare import (
    SheetComparison,
    compare_sensors,
    pixel_grid,
    sheet_difference_mm,
)
from calib.compare_rigs import compare_placings
from calib.compare_update import compare_sheets, compare_update
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
from calib.judging.cylinder import (
    CylinderJudgement,
    CylinderReading,
    judge_cylinder,
    judge_cylinders,
)
from calib.judging.distances import PlacementDistances, judge_distances
from calib.judging.leave_one_out import LeftOutPose, judge_leaving_out
from calib.judging.repeatability import Repeatability, judge_repeatability
from calib.plane import LightPlane
from calib.planning.doubt import SheetDoubt, information_of
from calib.planning.field import Coverage, field_of
from calib.planning.imagined import Scatter, imagined_view
from calib.planning.next_pose import NextPose, next_pose
from calib.planning.standing import Standing, pose_of, standing_of
from calib.rig import POSE_PARAMETERS, RIG_PARAMETERS, Rig, RigSensor, moved_by
from calib.rigid import RigidTransform
from calib.seeing.noise import PixelNoise
from calib.seeing.observe import observe_target
from calib.seeing.stripe import kernel_of, locate_stripe
from calib.sensor import SENSOR_PARAMETERS, LaserSensor
from calib.sheet_frame import SheetFrame
from calib.sheet_table import SheetTable
from calib.solving.bound import cramer_rao_bound
from calib.solving.calibrate import calibrate, calibrate_camera
from calib.solving.rig.answer import (
    RigCalibration,
    RigReach,
    SensorFit,
    SolvedBoard,
    SolvedRigView,
)
from calib.solving.rig.calibrate_rig import calibrate_rig
from calib.solving.rig.showing import RigShowing
from calib.solving.start import start_pose
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
    "Coverage",
    "CylinderJudgement",
    "CylinderReading",
    "Degenerate",
    "FloatArray",
    "IntArray",
    "LaserSensor",
    "LeftOutPose",
    "LightPlane",
    "Method",
    "NextPose",
    "NotConverged",
    "Picture",
    "PixelNoise",
    "PlacementDistances",
    "Repeatability",
    "POSE_PARAMETERS",
    "RIG_PARAMETERS",
    "Rig",
    "RigCalibration",
    "RigReach",
    "RigSensor",
    "RigShowing",
    "RigidTransform",
    "moved_by",
    "Scatter",
    "SheetComparison",
    "SheetDoubt",
    "SheetFrame",
    "SheetTable",
    "SolveReport",
    "SensorFit",
    "SolvedBoard",
    "SolvedPoints",
    "SolvedRigView",
    "SolvedView",
    "Standing",
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
    "calibrate_rig",
    "compare_placings",
    "compare_sensors",
    "compare_sheets",
    "compare_update",
    "cramer_rao_bound",
    "field_of",
    "frozen",
    "imagined_view",
    "information_of",
    "judge_cylinder",
    "judge_cylinders",
    "judge_distances",
    "judge_leaving_out",
    "judge_repeatability",
    "kernel_of",
    "locate_stripe",
    "next_pose",
    "observe_target",
    "pose_of",
    "read_only",
    "pixel_grid",
    "sheet_difference_mm",
    "standing_of",
    "start_pose",
]
