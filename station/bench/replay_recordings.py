"""Recordings for the bench of replaying: one of rendered wheels, and many by other names."""

import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from calib import Picture
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.recording import RecordingWriter
from station.scenes import WheelScene, WheelTruth, paper_sensor, trackside_mounting
from station.software import SOFTWARE

_SENSOR = "bench"
_OFFSETS_MM = (-20.0, 20.0)
_FRAME_NS, _WHEEL_NS = 18_867_925, 500_000_000


def true_calibration() -> CalibrationDocument:
    """Return the calibration of a sensor without any doubt."""
    truth, mounting = paper_sensor(), trackside_mounting("left")
    a, b, c, d = truth.plane.coefficients.tolist()
    return CalibrationDocument(
        sensor=_SENSOR,
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software=SOFTWARE,
        method="joint",
        camera=CameraDocument.from_model(truth.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=((0.0,) * 4,) * 4,
        rms=RmsDocument(dots_px=0.0, stripe_px=0.0),
        poses=(),
        quality={},
        options={},
        inputs=(),
        mounting=MountingDocument(
            rotation_vector=_three(mounting.rotation_vector.tolist()),
            translation_mm=_three(mounting.translation_mm.tolist()),
        ),
    )


def pictures_of_wheels(wheels: int) -> list[Picture]:
    """Render wheels, two pictures of each."""
    rng = np.random.default_rng(1)
    return [
        WheelScene(
            paper_sensor(),
            trackside_mounting("left"),
            WheelTruth(tread_wear_mm=float(wheel)),
            axle_offset_mm=offset_mm,
            seed=wheel,
        ).render(rng)
        for wheel in range(wheels)
        for offset_mm in _OFFSETS_MM
    ]


def record_wheels(path: Path, pictures: Sequence[Picture], *, frames: int) -> Path:
    """Record so many frames, the pictures over and over."""
    time_ns = 1_760_000_000_000_000_000
    with RecordingWriter(path) as writer:
        for number in range(1, frames + 1):
            picture = pictures[(number - 1) % len(pictures)]
            height, width = picture.shape
            pixels = picture.data.cast("B")
            writer.write_frame(_SENSOR, number, time_ns, time_ns, pixels, width, height)
            time_ns += _FRAME_NS if number % len(_OFFSETS_MM) else _WHEEL_NS
    return path


def copied(recording: Path, folder: Path, count: int) -> Path:
    """Return a folder with a recording by so many names; its bytes are on the disk once."""
    folder.mkdir()
    for number in range(count):
        os.link(recording, folder / f"train{number:05}.mcap")
    return folder


def damage(recording: Path) -> None:
    """Change a picture in a recording, of which other names have the bytes as they were."""
    content = bytearray(recording.read_bytes())
    content[len(content) // 2] ^= 1
    recording.unlink()
    recording.write_bytes(content)


def _three(values: Sequence[float]) -> tuple[float, float, float]:
    first, second, third = values
    return first, second, third
