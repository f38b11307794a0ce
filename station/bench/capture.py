"""Frames through the whole chain of capture: simulated camera, Aravis, shared memory, MCAP."""

import statistics
import tempfile
from pathlib import Path

import numpy as np

from calib import Picture
from station.capture import CaptureClient, RecordingPlan, start_capture
from station.progress import Progress
from station.recording import frames
from station.settings import SensorSettings
from station.simulated import ArraySource, Faults, SimulatedCameraProcess
from station.tables import Table, Value

WIDTH_PX, HEIGHT_PX = 2048, 1088
_ADDRESS = "127.0.53.9"
_DISTINCT = 16
_RUNS = 3


def bench_capture(progress: Progress, *, count: int = 200) -> Table:
    """Record at 53 frames/s without and with packets dropped, and compare every byte."""
    rows: list[dict[str, Value]] = []
    losses = [0.0, 0.01]
    for place, loss in enumerate(losses):
        runs = []
        for run in range(_RUNS):
            progress((place * _RUNS + run) / (len(losses) * _RUNS), f"{loss:.0%} dropped")
            runs.append(_record(count, loss, seed=run))
        rows.append(
            {
                "packets dropped": f"{loss:.1%}",
                "frames": count,
                "recorded (least)": min(run["recorded"] for run in runs),
                "differing (most)": max(run["differing"] for run in runs),
                "packets resent (median)": statistics.median(run["resent"] for run in runs),
            }
        )
    note = f"{WIDTH_PX} x {HEIGHT_PX} px at 53 frames/s, {_RUNS} runs each, camera on this host."
    return Table("Capture", rows, (note,))


def served_frames() -> ArraySource:
    """Return pictures whose every byte depends on which it is."""
    rng = np.random.default_rng(53)
    return ArraySource(
        [rng.integers(0, 256, (HEIGHT_PX, WIDTH_PX), dtype=np.uint8) for _ in range(_DISTINCT)]
    )
