"""The disk that takes the recordings: how fast, how much room."""

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from station.doctor.demand import Stream, bytes_per_s
from station.doctor.finding import Finding, judged, megabytes
from station.doctor.host import as_root
from station.errors import InputUnusable
from station.settings import StorageSettings

_PIECE_BYTES = 8 << 20
_TRIAL_BYTES = 256 << 20
_LONGEST_TRIAL_S = 6.0
_GB = 10**9
_MARGIN = 1.25
"""A disk has worse moments than the trial's."""
_ENOUGH_S = 600.0
"""Ten minutes of all cameras: the longest train, slow, and then another."""


def existing_folder(folder: Path) -> Path:
    """Return the folder, or the nearest one above it where it is still to be made.

    Raises
    ------
    InputUnusable
        If nothing can be written there.
    """
    there = folder
    while not there.exists():
        there = there.parent
    if not (there.is_dir() and os.access(there, os.W_OK | os.X_OK)):
        raise InputUnusable(
            f"{there} is not a folder this user can write to; change data_dir in the settings, or "
            f"type: {as_root(f'chown {os.geteuid()} {there}')}"
        )
    return there


def write_speed(
    folder: Path,
    *,
    size_bytes: int = _TRIAL_BYTES,
    longest_s: float = _LONGEST_TRIAL_S,
    now_s: Callable[[], float] = time.monotonic,
) -> float:
    """Write a file and put it on the disk, as the recorder does; return bytes a second.

    The file is gone afterwards.  A slow disk is asked for less, so that the trial ends.
    """
    piece = os.urandom(_PIECE_BYTES)  # a file system may compress, or leave out zeros
    with tempfile.TemporaryFile(dir=folder, prefix=".treadline-trial-", buffering=0) as trial:
        written, began_s = 0, now_s()
        while written < size_bytes and now_s() - began_s < longest_s:
            written += trial.write(piece)
            os.fdatasync(trial.fileno())
        return written / (now_s() - began_s)


def judge_speed(speed: float, folder: Path, streams: Sequence[Stream]) -> Finding:
    """Judge the disk: what it does not take fills the memory, then frames are lost."""
    rate = bytes_per_s(streams)
    seen = f"{megabytes(speed)}/s on the disk in {folder}, the cameras send {megabytes(rate)}/s"
    if speed < rate:
        room = sum(stream.ring_bytes for stream in streams)
        seen += f"; the rings alone bridge {room / (rate - speed):.0f} s of it"
    cure = (
        f"set data_dir to a disk that takes {megabytes(_MARGIN * rate)}/s, or lower frame_rate_hz "
        f"below {speed / _MARGIN / rate:.0%} of what the settings say"
    )
    return judged("disk speed", seen, good=speed >= _MARGIN * rate, cure=cure)


def judge_space(folder: Path, streams: Sequence[Stream], storage: StorageSettings) -> Finding:
    """Judge the room for recordings: one ends where the disk is full."""
    usage = shutil.disk_usage(folder)
    needed = bytes_per_s(streams) * _ENOUGH_S + storage.keep_free_gb * _GB
    seen = (
        f"{megabytes(usage.free)} of {megabytes(usage.total)} free in {folder}; ten minutes of the "
        f"cameras and keep_free_gb are {megabytes(needed)}"
    )
    cure = f"free {megabytes(needed - usage.free)}: du -h --max-depth=2 {folder} | sort -h | tail"
    return judged("free space", seen, good=usage.free >= needed, cure=cure)


def judge_quota(folder: Path, storage: StorageSettings) -> Finding:
    """Judge what makes recordings give way: a quota beyond the disk never does."""
    total = shutil.disk_usage(folder).total
    most = total - storage.keep_free_gb * _GB
    if storage.quota_gb is None:
        kept = "stay" if storage.keep_days is None else f"go after {storage.keep_days:g} days"
        return Finding(
            "quota", f"none: measured recordings {kept}; the disk has {megabytes(total)}"
        )
    seen = f"quota_gb = {storage.quota_gb:g} on a disk of {megabytes(total)}"
    cure = f"quota_gb = {0.9 * most / _GB:.0f} or less in [storage] of the settings"
    return judged("quota", seen, good=storage.quota_gb * _GB <= most, cure=cure)
