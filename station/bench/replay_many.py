"""Many recordings measured again by workers: how fast, in how much memory, and whoever dies."""

import os
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from calib import Picture
from station.bench.figures import Row, below, figure, none_of
from station.bench.replay_recordings import (
    copied,
    damage,
    pictures_of_wheels,
    record_wheels,
    true_calibration,
)
from station.exports import table_writer
from station.pipeline import measure_sources
from station.processes.one_core import use_one_core
from station.progress import Progress, silent
from station.replay import Means, Replay, ReplayReport, Workers, local_workers
from station.tables import Table

LEAST_GAIN, MOST_OVERHEAD, MOST_MEMORY_MB, MOST_GROWTH = 1.8, 0.05, 400.0, 2.0
_MOST_CPU = 2.0 / LEAST_GAIN
"""More than that, and two cores cannot reach the gain, however quiet the machine is."""
_KIB_PER_MIB = 1024


@dataclass(frozen=True, slots=True)
class _Size:
    """How much the bench does."""

    recordings: int
    frames: int
    short_frames: int
    long_frames: int
    planned: int


_FULL = _Size(recordings=200, frames=8, short_frames=50, long_frames=500, planned=10_000)
_SHORT = _Size(recordings=6, frames=2, short_frames=2, long_frames=20, planned=200)


def bench_replay_many(progress: Progress, *, short: bool = False) -> Table:
    """Measure recordings again with one worker and with two, and let things happen to them.

    Parameters
    ----------
    progress
        Told where the bench is.
    short
        Whether a little of everything will do: the times are then no figures.
    """
    size = _SHORT if short else _FULL
    use_one_core()
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as name:
        folder = Path(name)
        progress(0.0, "rendering")
        pictures = pictures_of_wheels(2)
        trains = _Trains.recorded(folder, pictures, size)
        progress(0.1, "a plain loop")
        loop_s = trains.plain_loop_s()
        progress(0.3, "one worker")
        with local_workers(1) as one:
            alone = trains.replayed(one, "one.csv")
            progress(0.4, "long recordings")
            memory = _memory(folder, pictures, size, one)
        progress(0.5, "two workers")
        with local_workers(2) as two:
            both = trains.replayed(two, "two.csv")
            progress(0.6, "a worker is killed")
            rows = [*_speeds(loop_s, alone, both), *_kill(trains, two)]
            progress(0.75, "one recording is damaged")
            rows += _damaged(trains, two)
        progress(0.9, "planning")
        rows += [memory, _planning(folder, trains, size)]
    return Table("Many recordings measured again", rows, _notes(size))


@dataclass(frozen=True, slots=True)
class _Run:
    """One replay."""

    seconds: float
    cpu_s: float
    """Of all workers."""
    report: ReplayReport
    table: bytes


@dataclass(frozen=True, slots=True)
class _Trains:
    """A folder of recordings."""

    folder: Path
    recordings: Path

    @classmethod
    def recorded(cls, folder: Path, pictures: Sequence[Picture], size: _Size) -> "_Trains":
        one = record_wheels(folder / "one.mcap", pictures, frames=size.frames)
        return cls(folder, copied(one, folder / "trains", size.recordings))

    def replay(self, out: str) -> Replay:
        return Replay([self.recordings], Means.of([true_calibration()]), self.folder / out)

    def replayed(self, crew: Workers, out: str, progress: Progress = silent) -> _Run:
        """Measure all of them, after what a worker needs to begin with."""
        first = sorted(self.recordings.iterdir())[:2]
        means = Means.of([true_calibration()])
        Replay(first, means, self.folder / "begun.csv").run_with(crew)
        cpu_s, began = sum(crew.on_each(time.process_time)), time.monotonic()
        report = self.replay(out).run_with(crew, progress)
        taken_s = time.monotonic() - began
        cpu_s = sum(crew.on_each(time.process_time)) - cpu_s
        return _Run(taken_s, cpu_s, report, (self.folder / out).read_bytes())

    def plain_loop_s(self) -> float:
        """Return what the same takes without any of it: each measured, then one table."""
        calibration = true_calibration()
        paths = sorted(self.recordings.iterdir())
        measure_sources(paths[:1], calibration)
        began = time.monotonic()
        found = [measure_sources([path], calibration) for path in paths]
        table = self.folder / "loop.csv"
        table_writer(table)(table, found[0], (wheel for one in found for wheel in one.wheels))
        return time.monotonic() - began


def _speeds(loop_s: float, alone: _Run, both: _Run) -> list[Row]:
    gain, overhead = alone.seconds / both.seconds, alone.seconds / loop_s - 1.0
    more = both.cpu_s / alone.cpu_s
    count = alone.report.recordings
    return [
        figure(
            f"{count} recordings, two workers over one, times",
            gain,
            f">= {LEAST_GAIN:g}",
            holds=gain >= LEAST_GAIN,
            spread=f"{alone.seconds:.3g} s, {both.seconds:.3g} s",
        ),
        figure(
            "processor time of two workers over that of one, times",
            more,
            f"<= {_MOST_CPU:.3g}",
            holds=more <= _MOST_CPU,
            spread=f"{alone.cpu_s:.3g} s, {both.cpu_s:.3g} s",
        ),
        figure(
            "one worker over a plain loop, share more",
            overhead,
            f"<= {MOST_OVERHEAD:g}",
            holds=overhead <= MOST_OVERHEAD,
            spread=f"{loop_s:.3g} s, {alone.seconds:.3g} s",
        ),
        none_of("bytes of the table that differ by the number of workers", _unlike(alone, both)),
    ]


def _unlike(one: _Run, other: _Run) -> int:
    differ = sum(a != b for a, b in zip(one.table, other.table, strict=False))
    return differ + abs(len(one.table) - len(other.table))


def _kill(trains: _Trains, crew: Workers) -> list[Row]:
    undisturbed = trains.replayed(crew, "undisturbed.csv")
    victims = crew.on_each(os.getpid)[:1]

    def kill_in_the_middle(done: float, _what: str) -> None:
        if done > 0.3 and victims:
            os.kill(victims.pop(), signal.SIGKILL)

    killed = trains.replayed(crew, "killed.csv", kill_in_the_middle)
    return [
        none_of("recordings lost with a killed worker", len(killed.report.refused)),
        none_of("bytes of the table that differ after it", _unlike(undisturbed, killed)),
    ]


def _damaged(trains: _Trains, crew: Workers) -> list[Row]:
    victim = sorted(trains.recordings.iterdir())[1]
    damage(victim)
    report = trains.replayed(crew, "damaged.csv").report
    named = [one.recording for one in report.refused]
    count = len(named) + report.recordings
    return [
        figure(
            f"named of {count} recordings, one of them damaged",
            ", ".join(named),
            victim.name,
            holds=named == [victim.name],
        ),
        figure("others in the table", report.recordings, f"{count - 1}", holds=len(named) == 1),
    ]


def _memory(folder: Path, pictures: Sequence[Picture], size: _Size, crew: Workers) -> Row:
    peaks = []
    for frames in (size.short_frames, size.long_frames):
        path = record_wheels(folder / f"{frames}.mcap", pictures, frames=frames)
        Replay([path], Means.of([true_calibration()]), folder / f"{frames}.csv").run_with(crew)
        peaks.append(max(crew.on_each(_peak_mb)))
        path.unlink()
    what = f"memory of a worker after {size.short_frames}, {size.long_frames} frames at once"
    return below(what, peaks, MOST_MEMORY_MB, "MB")


def _planning(folder: Path, trains: _Trains, size: _Size) -> Row:
    recording = next(trains.recordings.iterdir())
    each_ms = []
    for count in (size.planned // 10, size.planned):
        many = copied(recording, folder / f"many{count}", count)
        began = time.monotonic()
        forecast = Replay([many], Means.of([true_calibration()]), folder / "many").forecast()
        each_ms.append(1e3 * (time.monotonic() - began) / forecast.tasks)
    few, all_ = each_ms
    return figure(
        f"planning a task of {size.planned}, over one of a tenth of them, times",
        all_ / few,
        f"<= {MOST_GROWTH:g}",
        holds=all_ <= MOST_GROWTH * few,
        spread=f"{few:.3g} ms, {all_:.3g} ms",
    )


def _peak_mb() -> float:
    # Not `ru_maxrss`: across an exec it keeps that of the process that started this one.
    told = Path("/proc/self/status").read_text(encoding="ascii")
    (line,) = (line for line in told.splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) / _KIB_PER_MIB


def _notes(size: _Size) -> tuple[str, ...]:
    return (
        f"{size.frames} frames of 2048 x 1088 px a recording, from the disk's cache; BLAS and "
        "OpenCV with one thread; without the seconds that workers take to start.",
        "Other work on the cores takes its share of the gain and not of processor time.",
    )
