"""From files to answers: pictures and recordings to calibrations and wheel readings."""

from station.pipeline.calibrate import CalibrationOutcome, calibrate_sources
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import Frame, read_frames
from station.pipeline.intrinsics import calibrate_camera_from_sources
from station.pipeline.judge import (
    Solving,
    cylinders_of_sources,
    distances_of_sources,
    leaving_out_of_sources,
    repeatability_of_sources,
)
from station.pipeline.judge_field import MAP_STEP_PX, working_pixels
from station.pipeline.measure import measure_sources
from station.pipeline.observe import Observations, observe_sources
from station.pipeline.references import load_reference, read_profile

__all__ = [
    "MAP_STEP_PX",
    "CalibrationOutcome",
    "Frame",
    "Observations",
    "Solving",
    "calibrate_camera_from_sources",
    "calibrate_sources",
    "cylinders_of_sources",
    "distances_of_sources",
    "leaving_out_of_sources",
    "load_reference",
    "map_on_all_cores",
    "measure_sources",
    "observe_sources",
    "read_frames",
    "read_profile",
    "repeatability_of_sources",
    "working_pixels",
]
