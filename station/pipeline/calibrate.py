"""From pictures of a target to a calibration that can be questioned later."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from calib import Calibration, CameraModel, Method, Target, TooFewViews, View, calibrate
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    InputFile,
    MountingDocument,
    PlaneDocument,
    PoseDocument,
    RmsDocument,
    points_csv,
)
from station.errors import InputUnusable
from station.pipeline.frames import files_of
from station.pipeline.observe import Observations, observe_sources
from station.pipeline.quality import gates
from station.progress import Progress, silent
from station.settings import MountingSettings
from station.software import SOFTWARE

UNNAMED_SENSOR = "sensor"

_DISTANCES_MM = (20.0, 20_000.0)
"""Of targets from their camera; beyond these somebody has mistaken a unit."""
_MARGIN = 0.05
"""Of the picture's size: a dot cut by the border may have its centre a little outside."""


@dataclass(frozen=True, slots=True)
class CalibrationOutcome:
    """A calibration as it is kept: the document, every point, the pictures left out and why."""

    document: CalibrationDocument
    points_csv: str
    left_out: tuple[tuple[str, str], ...]


def calibrate_sources(
    sources: Sequence[Path],
    target: Target,
    *,
    sensor: str | None = None,
    camera: CameraModel | None = None,
    size_px: tuple[int, int] | None = None,
    method: Method = Method.JOINT,
    laser_off: Sequence[Path] = (),
    mounting: MountingSettings | None = None,
    progress: Progress = silent,
) -> CalibrationOutcome:
    """Calibrate a sensor from pictures, recordings or points.csv.

    `size_px`, width and height of the pictures, is needed where points are given without pictures
    and without a camera.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or the pictures do not fit the camera.
    RecordingUnreadable
        If a recording is damaged.
    CalibError
        If the pictures do not determine the sensor.
    """
    seen = observe_sources(
        sources,
        target,
        laser_off=laser_off,
        progress=lambda part, what: progress(0.9 * part, what),
    )
    width, height = picture_size(seen, camera, size_px)
    progress(0.9, f"solving {method}")
    try:
        answer = calibrate(
            seen.views, target, width=width, height=height, camera=camera, method=method
        )
    except TooFewViews as error:
        raise TooFewViews(f"{error}{seen.why_left_out}") from error
    left_out = (*seen.left_out, *((v.name, v.left_out) for v in answer.views if v.left_out))
    progress(1.0, "done")
    document = CalibrationDocument(
        sensor=sensor or seen.sensor or UNNAMED_SENSOR,
        created=datetime.now(UTC),
        software=SOFTWARE,
        method=answer.method,
        camera=CameraDocument.from_model(answer.sensor.camera),
        plane=_plane(answer),
        plane_covariance=answer.sensor.covariance[9:, 9:].tolist(),
        sensor_covariance=answer.sensor.covariance.tolist(),
        rms=RmsDocument(dots_px=answer.rms_dots_px, stripe_px=answer.rms_stripe_px),
        poses=_poses(answer),
        quality=gates(answer),
        options={"target": str(target), "method": method.value, "camera_given": camera is not None},
        inputs=fingerprints([*sources, *laser_off]),
        warnings=(*answer.warnings, *_unit_warnings(answer, target)),
        left_out=dict(left_out),
        mounting=MountingDocument.from_settings(mounting) if mounting else None,
    )
    return CalibrationOutcome(document, points_csv(answer), left_out)


def picture_size(
    seen: Observations, camera: CameraModel | None, size_px: tuple[int, int] | None = None
) -> tuple[int, int]:
    """Return width and height of the pictures observed, px; `size_px` where only points are.

    Raises
    ------
    InputUnusable
        If they are not of the camera's size, neither pictures nor camera tell one, or a point lies
        outside them.
    """
    size = _size(seen, camera, size_px)
    for view in seen.views:
        _refuse_outside(view, size)
    return size


def _size(
    seen: Observations, camera: CameraModel | None, size_px: tuple[int, int] | None
) -> tuple[int, int]:
    if camera is None:
        if seen.width is not None and seen.height is not None:
            return seen.width, seen.height
        if size_px is None:
            raise InputUnusable(
                "points alone do not tell the size of the pictures; give --camera camera.json or "
                "--size WIDTHxHEIGHT"
            )
        return size_px
    if seen.width is not None and (seen.width, seen.height) != (camera.width, camera.height):
        raise InputUnusable(
            f"pictures of {seen.width} x {seen.height} px but a camera of {camera.width} x "
            f"{camera.height}; give the camera file of these pictures, or none to solve it"
        )
    return camera.width, camera.height


def _refuse_outside(view: View, size_px: tuple[int, int]) -> None:
    stripe_px = view.stripe.centre_px if view.stripe is not None else np.empty((0, 2))
    seen_px = np.vstack([view.points.centre_px, stripe_px])
    margin = _MARGIN * np.array(size_px)
    outside = ((seen_px < -margin) | (seen_px > size_px + margin)).any(axis=1)
    if outside.any():
        (u, v), (width, height) = seen_px[outside][0], size_px
        raise InputUnusable(
            f"{view.name}: a point at {u:.0f}, {v:.0f} px but pictures of {width} x {height}; "
            "allowed: points inside; give the camera file or --size of these pictures"
        )


def _unit_warnings(answer: Calibration, target: Target) -> tuple[str, ...]:
    poses = [view.cam_from_board for view in answer.views if view.cam_from_board is not None]
    distance_mm = float(np.median([pose.translation_mm[2] for pose in poses]))
    if _DISTANCES_MM[0] <= distance_mm <= _DISTANCES_MM[1]:
        return ()
    return (
        f"by its pitch of {target.pitch_mm:g} mm the target stood {distance_mm:.3g} mm from the "
        "camera; is the pitch in mm? Everything scales with it",
    )


def _plane(answer: Calibration) -> PlaneDocument:
    a, b, c, d = answer.sensor.plane.coefficients.tolist()
    return PlaneDocument(a=a, b=b, c=c, d=d)


def _poses(answer: Calibration) -> tuple[PoseDocument, ...]:
    solved = ((view.name, view.cam_from_board) for view in answer.views)
    return tuple(
        PoseDocument(
            image=name,
            rotation_vector=tuple(pose.rotation_vector.tolist()),
            translation_mm=tuple(pose.translation_mm.tolist()),
        )
        for name, pose in solved
        if pose is not None
    )


def fingerprints(sources: Sequence[Path]) -> tuple[InputFile, ...]:
    """Name and SHA-256 of every file that the sources stand for."""
    tables = [source for source in sources if source.suffix.lower() == ".csv"]
    files = tables + files_of([source for source in sources if source not in tables])
    return tuple(InputFile(name=path.name, sha256=sha256_of(path)) for path in files)


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
