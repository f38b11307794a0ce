"""Recordings for the bench of replaying: one of rendered wheels, and many by other names."""

import os
from collections.abc import Sequence
from pathlib import Path

from calib import Picture
from station.bench.exact_calibration import exact_calibration
from station.bench.rendered_wheels import rendered_wheels
from station.documents import CalibrationDocument
from station.recording import RecordingWriter

_SENSOR = "bench"
_OFFSETS_MM = (-20.0, 20.0)
_FRAME_NS, _WHEEL_NS = 18_867_925, 500_000_000


def true_calibration() -> CalibrationDocument:
    """Return the calibration of the recorded sensor, without any doubt."""
    return exact_calibration(_SENSOR)


def pictures_of_wheels(wheels: int) -> list[Picture]:
    """Render wheels, two pictures of each."""
    return rendered_wheels(wheels, _OFFSETS_MM)


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
