"""Frames through the whole chain of capture, camera to file: the parts of `bench capture`."""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from station.bench.capture_bad_files import bench_bad_files
from station.bench.capture_disk import bench_full_disk
from station.bench.capture_kills import bench_kills
from station.bench.capture_packets import bench_packets
from station.bench.capture_rate import bench_rate
from station.bench.capture_returns import bench_returns
from station.bench.replay import bench_replay
from station.errors import InputUnusable
from station.progress import Progress
from station.tables import Table


@dataclass(frozen=True, slots=True)
class Extent:
    """How long the parts are."""

    seconds: float = 5.0
    """Of one camera at full rate."""
    pair_seconds: float = 5.0
    """Of two cameras at full rate."""
    packet_frames: int = 50
    """Through a link with each of the faults."""
    kills: int = 3
    returns: int = 2

    def __post_init__(self) -> None:
        for name in ("seconds", "pair_seconds", "packet_frames", "kills", "returns"):
            if not (getattr(self, name) > 0):
                raise ValueError(f"{name} must be more than 0, got {getattr(self, name)}")


SHORT = Extent()
"""Two minutes in all."""
FULL = Extent(seconds=600.0, pair_seconds=60.0, packet_frames=600, kills=50, returns=10)
"""What is asked of a station; half an hour."""

_PartBench = Callable[[Progress, Path], Table]


def _parts(extent: Extent) -> Mapping[str, _PartBench]:
    return {
        "rate": partial(bench_rate, seconds=extent.seconds),
        "pair": partial(bench_rate, seconds=extent.pair_seconds, cameras=2),
        "packets": partial(bench_packets, count=extent.packet_frames),
        "kills": partial(bench_kills, kills=extent.kills),
        "returns": partial(bench_returns, returns=extent.returns),
        "full-disk": bench_full_disk,
        "bad-files": bench_bad_files,
        "replay": _replay,
    }


def _replay(progress: Progress, _folder: Path) -> Table:
    return bench_replay(progress)


CAPTURE_PARTS = tuple(_parts(SHORT))
"""Names of what `bench capture` measures."""


def capture_benches(
    parts: Sequence[str] = CAPTURE_PARTS,
    *,
    full: bool = False,
    minutes: float | None = None,
    folder: Path | None = None,
) -> list[Callable[[Progress], Table]]:
    """Return the benches of capture, a table each.

    Parameters
    ----------
    parts
        Which of them, all by default.
    full
        As long as the station's requirements ask, instead of short.
    minutes
        How long one camera runs at full rate, whatever `full` says.
    folder
        Where the recordings go: a disk, or memory; the system's temporary folder by default.

    Raises
    ------
    InputUnusable
        If there is no such part or folder.
    """
    extent = FULL if full else SHORT
    if minutes is not None:
        extent = replace(extent, seconds=60.0 * minutes)
    if folder is not None and not folder.is_dir():
        raise InputUnusable(f"--folder {folder}: no such folder; make it first")
    known = _parts(extent)
    for name in parts:
        if name not in known:
            raise InputUnusable(f"--part {name!r}; allowed: {', '.join(known)}")
    return [partial(_in_own_folder, known[name], folder) for name in parts]


def _in_own_folder(part: _PartBench, folder: Path | None, progress: Progress) -> Table:
    with tempfile.TemporaryDirectory(prefix="treadline-bench-", dir=folder) as own:
        return part(progress, Path(own))
