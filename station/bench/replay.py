"""How fast recordings are read again, with the stripe located, and with the wheels measured."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from calib import LaserSensor, Picture
from measure import Mounting, WheelFrame, each_wheel, reference_profile
from station.bench.rendered_wheels import rendered_wheels
from station.bench.timing import CoreTime
from station.errors import StationError
from station.pipeline import UnreadBatch, WheelGauge, recorded_batches
from station.progress import Progress
from station.recording import RecordingWriter
from station.scenes import paper_sensor, trackside_mounting
from station.tables import Table, Value

ASKED_FRAMES_PER_S = 200
_SENSOR = "bench"
_OFFSETS_MM = (-20.0, 0.0, 20.0)
_FRAME_NS, _WHEEL_NS = 18_867_925, 500_000_000
_TIMES_OVER = 4  # each picture in the recording, so that starting costs little a frame


def bench_replay(progress: Progress, *, wheels: int = 3, runs: int = 7) -> Table:
    """Read a recording of rendered wheels on one core, as `station replay` does.

    Parameters
    ----------
    progress
        Told where the bench is.
    wheels
        Wheels rendered, three pictures of each.
    runs
        Runs of each piece of work; the table has their median.
    """
    gauge = _gauge(paper_sensor())
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder:
        path = Path(folder, "wheels.mcap")
        progress(0.0, "rendering")
        count = _record(path, rendered_wheels(wheels, _OFFSETS_MM))
        work = {
            "reading alone": lambda: _read(path),
            "and locating the stripe": lambda: _located(path, gauge),
            "and measuring the wheels": lambda: [
                gauge.measure(wheel) for wheel in each_wheel(_located(path, gauge))
            ],
        }
        times = {}
        for place, (name, do) in enumerate(work.items(), start=1):
            progress(place / (len(work) + 1), name)
            times[name] = CoreTime.of(do, runs=runs)
    alone_s = times["reading alone"].median_s
    rows = [_row(name, taken, count, alone_s) for name, taken in times.items()]
    notes = (
        f"{count} frames of 2048 x 1088 px from the disk's cache, every checksum computed; "
        f"time of one core, the median of {runs} runs.",
        f"Asked of reading with the stripe located: {ASKED_FRAMES_PER_S} frames/s.",
    )
    return Table("Replay", rows, notes)


def _row(name: str, taken: CoreTime, count: int, alone_s: float) -> dict[str, Value]:
    return {
        "work": name,
        "frames/s of a core": count / taken.median_s,
        "ms a frame": 1e3 * taken.median_s / count,
        "spread": taken.spread_s / taken.median_s,
        "times reading alone": taken.median_s / alone_s,
    }


def _gauge(sensor: LaserSensor) -> WheelGauge:
    return WheelGauge(
        sensor=sensor,
        sensor_id=_SENSOR,
        mounting=Mounting(rig_from_camera=trackside_mounting("left")),
        reference=reference_profile("S1002"),
        made_of=("", ""),  # it stays in this process
    )


def _record(path: Path, pictures: Sequence[Picture]) -> int:
    time_ns, shown = 1, [*pictures] * _TIMES_OVER
    with RecordingWriter(path) as writer:
        for number, picture in enumerate(shown, start=1):
            height, width = picture.shape
            pixels = picture.data.cast("B")
            writer.write_frame(_SENSOR, number, time_ns, time_ns, pixels, width, height)
            time_ns += _FRAME_NS if number % len(_OFFSETS_MM) else _WHEEL_NS
    return len(shown)


def _read(path: Path) -> int:
    batches = recorded_batches([path], path.name)
    return sum(frame.picture.shape[0] for batch in batches for frame in batch.frames())


def _located(path: Path, gauge: WheelGauge) -> list[WheelFrame]:
    found: list[WheelFrame] = []
    for batch in recorded_batches([path], path.name):
        answer = gauge.locate(batch)
        if isinstance(answer, UnreadBatch):
            raise StationError(f"the bench cannot read its own recording: {answer.error}")
        found += answer
    return found
