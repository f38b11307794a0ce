"""From pictures of things whose size is known to how good a calibration is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib import (
    CameraModel,
    CylinderJudgement,
    FloatArray,
    LaserSensor,
    LeftOutPose,
    Method,
    Picture,
    PlacementDistances,
    Repeatability,
    StripePoints,
    Target,
    judge_cylinders,
    judge_distances,
    judge_leaving_out,
    judge_repeatability,
    locate_stripe,
)
from station.errors import InputUnusable
from station.pipeline.calibrate import picture_size
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import count_frames, read_frames
from station.pipeline.observe import Observations, observe_sources
from station.progress import Progress, silent

_LOCATE_S = 0.1
"""What the stripe of a whole picture takes, about."""

LeftOut = tuple[tuple[str, str], ...]
"""(name, reason) of pictures in which the target was not found."""


def distances_of_sources(
    sources: Sequence[Path], target: Target, sensor: LaserSensor, *, progress: Progress = silent
) -> tuple[tuple[PlacementDistances, ...], LeftOut]:
    """Measure distances on a target in every picture of the sources.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or the pictures do not fit the sensor's camera.
    RecordingUnreadable
        If a recording is damaged.
    """
    seen = observe_sources(sources, target, progress=progress)
    picture_size(seen, sensor.camera)
    return judge_distances(seen.views, target, sensor), seen.left_out


def cylinders_of_sources(
    sources: Sequence[Path],
    sensor: LaserSensor,
    radius_mm: float,
    *,
    axis_in_cam: FloatArray | None = None,
    one_axis: bool = False,
    progress: Progress = silent,
) -> CylinderJudgement:
    """Measure the radius of one cylinder in all pictures of the sources.

    The axis is as for `calib.judge_cylinders`.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or a picture does not fit the sensor's camera.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable("no SOURCE given; give recordings, pictures or folders")
    total, names = count_frames(sources), []

    def pictures() -> Iterator[Picture]:
        for frame in read_frames(sources):
            height, width = frame.picture.shape
            _check_size(frame.name, (width, height), sensor.camera)
            names.append(frame.name)
            yield frame.picture

    seen: list[tuple[str, StripePoints]] = []
    stripes: Iterator[StripePoints] = map_on_all_cores(
        locate_stripe, pictures(), count=total, seconds_each=_LOCATE_S
    )
    for done, stripe in enumerate(stripes):
        progress((done + 1) / total, f"picture {done + 1} of {total}")
        seen.append((names[done], stripe))
    return judge_cylinders(seen, sensor, radius_mm, axis_in_cam=axis_in_cam, one_axis=one_axis)


def _check_size(name: str, size: tuple[int, int], camera: CameraModel) -> None:
    if size != (camera.width, camera.height):
        raise InputUnusable(
            f"{name} is {size[0]} x {size[1]} px but the calibration is of {camera.width} x "
            f"{camera.height}; give pictures of the same camera"
        )


@dataclass(frozen=True, slots=True)
class Solving:
    """How pictures are calibrated when they are calibrated again and again.

    Attributes
    ----------
    target
        The target in them.
    camera
        Its model; None where it is solved with the rest.
    """

    target: Target
    camera: CameraModel | None


def repeatability_of_sources(
    sources: Sequence[Path],
    solving: Solving,
    *,
    methods: Sequence[Method] = tuple(Method),
    draws: int = 20,
    take: int = 10,
    seed: int = 0,
    progress: Progress = silent,
) -> tuple[Repeatability, ...]:
    """Calibrate from parts of the pictures, drawn at random; the same parts for every method.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or the pictures do not fit the camera.
    RecordingUnreadable
        If a recording is damaged.
    CalibError
        If there are too few pictures, or nearly no part determines the sensor.
    """
    seen, (width, height) = _observe(sources, solving, progress)
    answers = []
    for done, method in enumerate(methods):
        progress(0.5 + 0.5 * done / len(methods), f"solving {draws} times by {method}")
        answers.append(
            judge_repeatability(
                seen.views,
                solving.target,
                np.random.default_rng(seed),
                width=width,
                height=height,
                camera=solving.camera,
                method=method,
                draws=draws,
                take=take,
            )
        )
    return tuple(answers)


def leaving_out_of_sources(
    sources: Sequence[Path],
    solving: Solving,
    *,
    method: Method = Method.JOINT,
    progress: Progress = silent,
) -> tuple[tuple[LeftOutPose, ...], LeftOut]:
    """Calibrate without each picture in turn, and measure its stripe by the others.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or the pictures do not fit the camera.
    RecordingUnreadable
        If a recording is damaged.
    """
    seen, (width, height) = _observe(sources, solving, progress)
    progress(0.5, f"solving {len(seen.views)} times by {method}")
    poses = judge_leaving_out(
        seen.views,
        solving.target,
        width=width,
        height=height,
        camera=solving.camera,
        method=method,
    )
    return poses, seen.left_out


def _observe(
    sources: Sequence[Path], solving: Solving, progress: Progress
) -> tuple[Observations, tuple[int, int]]:
    seen = observe_sources(
        sources, solving.target, progress=lambda part, what: progress(0.5 * part, what)
    )
    return seen, picture_size(seen, solving.camera)
