"""Stripes on a reference piece, from pictures with the laser on and, if given, off."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from calib import CameraModel, Picture, PixelNoise, StripePoints, locate_stripe
from station.errors import InputUnusable
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import Frame, alike, count_frames, read_frames
from station.pipeline.showings import SeenPose
from station.progress import Progress

_LOCATE_S = 0.1
_Task = tuple[Picture, Picture | None]


def stripes_of(
    sources: Sequence[Path],
    sensor: str,
    camera: CameraModel,
    *,
    laser_off: Sequence[Path] = (),
    progress: Progress,
) -> Iterator[SeenPose]:
    """Yield of every picture of the sources all ridges in it.

    Parameters
    ----------
    sources
        Pictures of one sensor.
    sensor, camera
        Its name, and the camera it is calibrated with.
    laser_off
        The same with the laser off: one picture for all, or one for each.
    progress
        Told how far it is.

    Raises
    ------
    InputUnusable
        If a source cannot be used, a picture does not fit the sensor, or the laser-off pictures
        do not pair with the others.
    RecordingUnreadable
        If a recording is damaged.
    """
    total, taken = count_frames(sources), list[tuple[str, int | None]]()

    def tasks() -> Iterator[_Task]:
        for frame, dark in _paired(sources, laser_off):
            _ensure_fits(frame, sensor, camera)
            taken.append((frame.name, frame.time_ns))
            yield frame.picture, dark

    stripes: Iterator[StripePoints] = map_on_all_cores(
        _locate, tasks(), count=total, seconds_each=_LOCATE_S
    )
    for done, stripe in enumerate(stripes):
        progress((done + 1) / total, f"picture {done + 1} of {total}")
        name, time_ns = taken[done]
        yield SeenPose(name, stripe, time_ns)


def _paired(
    sources: Sequence[Path], laser_off: Sequence[Path]
) -> Iterator[tuple[Frame, Picture | None]]:
    if not laser_off:
        for frame in read_frames(sources):
            yield frame, None
        return
    total, darks = count_frames(sources), count_frames(laser_off)
    if darks not in {1, total}:
        raise InputUnusable(
            f"{darks} laser-off pictures for {total} pictures; allowed: one for all, or one for "
            "each in the same order"
        )
    dark_frames = read_frames(laser_off)
    dark = next(dark_frames)
    for place, frame in enumerate(read_frames(sources)):
        if place and darks > 1:
            dark = next(dark_frames)
        yield frame, alike(dark, frame).picture


def _ensure_fits(frame: Frame, sensor: str, camera: CameraModel) -> None:
    height, width = frame.picture.shape
    if (width, height) != (camera.width, camera.height):
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but the calibration is of {camera.width} x "
            f"{camera.height}; give pictures of the same camera"
        )
    if frame.sensor not in {None, sensor}:
        raise InputUnusable(
            f"{frame.name} is of sensor {frame.sensor} but the calibration is of {sensor}; give "
            "the calibration of that sensor"
        )


def _locate(task: _Task) -> StripePoints:
    picture, dark = task
    if dark is None:
        return locate_stripe(picture)
    of_dark = PixelNoise.from_picture(dark)
    lit = np.asarray(cv2.subtract(picture, dark), dtype=np.uint8)
    # The noise of both pictures is in the difference.
    return locate_stripe(lit, noise=PixelNoise(2.0 * of_dark.floor, of_dark.gain))
