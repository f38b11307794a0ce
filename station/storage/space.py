"""Whether what is about to be recorded fits on the disk: asked before a train comes, not after."""

import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from station.errors import DiskFull
from station.settings import SensorSettings, StorageSettings

GB = 10**9
_MESSAGE_BYTES = 512
"""What a frame takes in a recording beside its picture; 200 were measured."""
_LARGEST_PICTURE_BYTES = 2048 * 1088
"""Of the cameras in use; asked for where a camera does not say its own size."""


@dataclass(frozen=True, slots=True)
class Expected:
    """What one sensor is expected to record at most."""

    sensor: str
    frames: int
    size_bytes: int

    def __str__(self) -> str:
        """Say it with numbers."""
        return f"{self.sensor} {self.frames} frames, {self.size_bytes / GB:.2f} GB"


def expected_of_pass(
    sensor: SensorSettings, storage: StorageSettings, picture_bytes: int | None
) -> Expected:
    """Return what a sensor records of the longest pass.

    A sensor that runs free takes `frame_rate_hz` for `longest_pass_s`, another a frame an axle.
    """
    if sensor.trigger == "free":
        frames = round(sensor.frame_rate_hz * storage.longest_pass_s)
    else:
        frames = storage.most_axles
    return _expected(sensor, frames, picture_bytes)


def expected_of_session(
    sensor: SensorSettings, storage: StorageSettings, picture_bytes: int | None
) -> Expected:
    """Return what a sensor records of a calibration session."""
    frames = storage.most_poses * max(1, len(sensor.calibration_exposures))
    return _expected(sensor, frames, picture_bytes)


def _expected(sensor: SensorSettings, frames: int, picture_bytes: int | None) -> Expected:
    each = (picture_bytes or _LARGEST_PICTURE_BYTES) + _MESSAGE_BYTES
    return Expected(sensor.id, frames, frames * each)


def free_bytes(folder: Path) -> int:
    """Return the space left for this user on the disk of a folder."""
    return shutil.disk_usage(folder).free


def ensure_space(
    folder: Path,
    expected: Iterable[Expected],
    keep_free_gb: float,
    wanted: str,
    free_of: Callable[[Path], int] = free_bytes,
) -> None:
    """Let a recording begin only where it fits, with `keep_free_gb` left over.

    Raises
    ------
    DiskFull
        If it does not.
    """
    each = list(expected)
    needed = sum(one.size_bytes for one in each) + round(keep_free_gb * GB)
    free = free_of(folder)
    if not (free >= needed):
        parts = "; ".join(map(str, each))
        raise DiskFull(
            f"{wanted} needs {needed / GB:.2f} GB free in {folder} ({parts}; {keep_free_gb:g} GB "
            f"kept free) and {free / GB:.2f} GB are: delete or move recordings, or set quota_gb or "
            "keep_days in [storage]"
        )
