"""Frames through the whole chain of capture: simulated camera, Aravis, shared memory, MCAP."""

import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from station.capture import (
    CaptureClient,
    CaptureReport,
    CaptureState,
    RecordingPlan,
    Trigger,
    start_capture,
)
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
        rows.append({
            "packets dropped": f"{loss:.1%}",
            "frames": count,
            "recorded (least)": min(run["recorded"] for run in runs),
            "differing (most)": max(run["differing"] for run in runs),
            "packets resent (median)": statistics.median(run["resent"] for run in runs),
        })
    note = f"{WIDTH_PX} x {HEIGHT_PX} px at 53 frames/s, {_RUNS} runs each, camera on this host."
    return Table("Capture", rows, (note,))


def _record(count: int, loss: float, *, seed: int) -> dict[str, int]:
    """Record once, and count what arrived and what differs from what was served."""
    served = served_frames()
    camera = SimulatedCameraProcess(
        _ADDRESS, served_frames, faults=Faults(packet_loss=loss, seed=seed)
    )
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder, camera:
        path = Path(folder, "bench.mcap")
        report = _capture(path, count)
        differing = sum(
            not np.array_equal(frame.picture, served.frame(place, 0.0))
            for place, frame in enumerate(frames(path))
        )
    return {"recorded": report.recorded, "resent": report.resent_packets, "differing": differing}


def _capture(path: Path, count: int) -> CaptureReport:
    settings = SensorSettings(id="bench", address=_ADDRESS, trigger="free", frame_rate_hz=53.0)
    socket_path = path.with_suffix(".sock")
    process = start_capture(settings, socket_path)
    try:
        client = CaptureClient(socket_path)
        client.arm(RecordingPlan("bench", path, "bench", trigger=Trigger.FREE, frames=count))
        while client.status().state is not CaptureState.RECORDED:
            time.sleep(0.1)
        report = client.finish(expected_frames=count)
        client.shutdown()
        return report
    finally:
        process.join(10.0)
        process.kill()


def served_frames() -> ArraySource:
    """Return pictures whose every byte depends on which it is."""
    rng = np.random.default_rng(53)
    return ArraySource([
        rng.integers(0, 256, (HEIGHT_PX, WIDTH_PX), dtype=np.uint8) for _ in range(_DISTINCT)
    ])
