"""From files to answers: pictures and recordings to calibrations and wheel readings."""

from station.pipeline.axles import on_axles
from station.pipeline.batches import Batch, recorded_batches
from station.pipeline.calibrate import CalibrationOutcome, calibrate_sources
from station.pipeline.cores import Cores, all_cores, map_on_all_cores
from station.pipeline.exposures import Exposure
from station.pipeline.following import (
    Looker,
    Taken,
    WheelFollower,
    looking_rig,
    looking_sensor,
)
from station.pipeline.frames import Frame, read_frames
from station.pipeline.gauge import UnreadBatch, WheelGauge
from station.pipeline.gauge_files import gauge_files
from station.pipeline.intrinsics import calibrate_camera_from_sources
from station.pipeline.judge import (
    Solving,
    cylinders_of_sources,
    distances_of_sources,
    leaving_out_of_sources,
    repeatability_of_sources,
)
from station.pipeline.judge_field import MAP_STEP_PX, working_pixels
from station.pipeline.measure import FRAME_S, measure_sources, measured_wheels
from station.pipeline.measure_rig import measure_rig, measured_on_rig
from station.pipeline.measure_train import measure_train
from station.pipeline.naming import distinct_names
from station.pipeline.new_references import register_reference
from station.pipeline.observe import Observations, observe_pose, observe_sources
from station.pipeline.observe_group import PoseShot, observe_group
from station.pipeline.piece import check_piece
from station.pipeline.piece_on_rig import calibrate_rig_on_piece, check_piece_on_rig
from station.pipeline.piece_order import PieceOrder
from station.pipeline.quality import LARGEST_SHEET_SIGMA_MM, LARGEST_SIGMA_SCALE
from station.pipeline.references import is_json, load_reference, read_profile, read_reference
from station.pipeline.resumption import Resumption
from station.pipeline.rig import RigOrder, RigOutcome, calibrate_rig_sources
from station.pipeline.rig_gauge import RigGauge
from station.pipeline.rig_sources import sources_by_sensor
from station.pipeline.shifts import SeenBefore, shifts_with
from station.pipeline.wheel_stripe import locate_wheel_stripe

__all__ = [
    "FRAME_S",
    "LARGEST_SHEET_SIGMA_MM",
    "LARGEST_SIGMA_SCALE",
    "MAP_STEP_PX",
    "Batch",
    "CalibrationOutcome",
    "Cores",
    "Exposure",
    "Frame",
    "Looker",
    "Observations",
    "PieceOrder",
    "Resumption",
    "RigGauge",
    "RigOrder",
    "RigOutcome",
    "PoseShot",
    "SeenBefore",
    "Solving",
    "Taken",
    "UnreadBatch",
    "WheelFollower",
    "WheelGauge",
    "all_cores",
    "calibrate_camera_from_sources",
    "calibrate_rig_on_piece",
    "calibrate_rig_sources",
    "calibrate_sources",
    "check_piece",
    "check_piece_on_rig",
    "cylinders_of_sources",
    "distances_of_sources",
    "distinct_names",
    "gauge_files",
    "is_json",
    "leaving_out_of_sources",
    "load_reference",
    "locate_wheel_stripe",
    "looking_rig",
    "looking_sensor",
    "map_on_all_cores",
    "measure_rig",
    "measure_sources",
    "measure_train",
    "measured_on_rig",
    "measured_wheels",
    "observe_group",
    "observe_pose",
    "observe_sources",
    "on_axles",
    "read_frames",
    "read_profile",
    "read_reference",
    "recorded_batches",
    "register_reference",
    "repeatability_of_sources",
    "shifts_with",
    "sources_by_sensor",
    "working_pixels",
]
