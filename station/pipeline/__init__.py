"""From files to answers: pictures and recordings to calibrations and wheel readings."""

from station.pipeline.batches import Batch, recorded_batches
from station.pipeline.calibrate import CalibrationOutcome, calibrate_sources
from station.pipeline.cores import all_cores, map_on_all_cores
from station.pipeline.exposures import Exposure
from station.pipeline.frames import Frame, read_frames
from station.pipeline.gauge import UnreadBatch, WheelGauge
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
from station.pipeline.naming import distinct_names
from station.pipeline.observe import Observations, observe_sources
from station.pipeline.observe_group import Shot, observe_group
from station.pipeline.references import load_reference, read_profile

__all__ = [
    "FRAME_S",
    "MAP_STEP_PX",
    "Batch",
    "CalibrationOutcome",
    "Exposure",
    "Frame",
    "Observations",
    "Shot",
    "Solving",
    "UnreadBatch",
    "WheelGauge",
    "all_cores",
    "calibrate_camera_from_sources",
    "calibrate_sources",
    "cylinders_of_sources",
    "distances_of_sources",
    "distinct_names",
    "leaving_out_of_sources",
    "load_reference",
    "map_on_all_cores",
    "measure_sources",
    "measured_wheels",
    "observe_group",
    "observe_sources",
    "read_frames",
    "read_profile",
    "recorded_batches",
    "repeatability_of_sources",
    "working_pixels",
]
