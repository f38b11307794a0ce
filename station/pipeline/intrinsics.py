"""From pictures of a target to the camera model alone."""

from collections.abc import Sequence
from pathlib import Path

from calib import CameraModel, Target, TooFewViews, calibrate_camera
from station.errors import InputUnusable
from station.pipeline.observe import observe_sources
from station.progress import Progress, silent


def calibrate_camera_from_sources(
    sources: Sequence[Path], target: Target, *, progress: Progress = silent
) -> CameraModel:
    """Solve the camera from pictures or recordings of a target.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or only points are given.
    RecordingUnreadable
        If a recording is damaged.
    CalibError
        If the pictures do not determine the camera.
    """
    seen = observe_sources(sources, target, progress=progress)
    if seen.width is None or seen.height is None:
        raise InputUnusable("points alone do not tell the size of the pictures; give pictures")
    try:
        return calibrate_camera(seen.views, target, width=seen.width, height=seen.height).camera
    except TooFewViews as error:
        raise TooFewViews(f"{error}{seen.why_left_out}") from error
