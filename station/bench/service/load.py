"""Calls at a steady rate while a train is recorded and others are measured."""

import math
import multiprocessing
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from station.bench.service.filled_store import Traffic
from station.bench.service.ground import Extent, Ground
from station.bench.service.open_loop import Answered, Call, Driven, Load, drive
from station.bench.service.peer_app import served_peer
from station.bench.service.readings_seen import ReadingsSeen
from station.bench.service.serving import Serving
from station.client import Answer
from station.progress import Progress
from station.tables import Table, Value

ASKED_GET_MS, ASKED_PUT_MS, ASKED_READING_MS = 20.0, 50.0, 1000.0
_RATE_HZ = 200.0
_PASS = "running"
_ARMINGS = 5
_PATIENCE_S = 120.0
_WARM_UP_HZ, _WARM_UP_S = 50.0, 2.0
_LATE = 99.0


@dataclass(frozen=True, slots=True)
class _Window:
    """One stretch of load: how its calls were answered, and what it cost.

    Attributes
    ----------
    core_s
        Processor seconds by part of the station.
    """

    driven: Driven
    core_s: Mapping[str, float]

    def of(self, kind: str) -> list[Answered]:
        """Return the calls of a kind, or of all that begin with it."""
        return [each for each in self.driven.answers if each.name.startswith(kind)]

    @property
    def rate_hz(self) -> float:
        """Calls answered a second."""
        return len(self.driven.answers) / self.driven.took_s


@dataclass(frozen=True, slots=True)
class _Findings:
    """All that was seen of the station.

    Attributes
    ----------
    idle, busy, behind
        It waits; records and measures the train that passes; measures another one as well.
    peer
        The bare app, called in the place of the station while that does all of it.
    armed_ms
        New passes, while it is idle.
    late_s
        Of each reading: how long after the last frame of its wheel it could be had.
    recording
        What the pass came to.
    trains
        Others measured meanwhile.
    """

    idle: _Window
    busy: _Window
    behind: _Window
    peer: _Window
    armed_ms: Sequence[float]
    late_s: Sequence[float]
    late_behind_s: Sequence[float]
    recording: Answer
    trains: int


def bench_service(
    progress: Progress, *, seconds: float = 20.0, rate_hz: float = _RATE_HZ, wheels: int = 100
) -> Table:
    """Call a station at a steady rate, idle and while it records at full rate and measures.

    Parameters
    ----------
    progress
        Told where the bench is.
    seconds
        Of each stretch of load.
    rate_hz
        Calls a second.
    wheels
        Of each train that waits to be measured; 7 MB of disk a wheel.
    """
    extent = Extent(
        past=Traffic(passes=max(2, wheels), axles=max(2, wheels // 2)),
        wheels=wheels,
        longest_pass_s=3.0 * seconds + 60.0,
    )
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder, _caller() as caller:
        ground = Ground.prepared(Path(folder), extent, progress)
        with Serving(ground) as serving, served_peer() as peer_port:
            bench = _Bench(ground, serving, caller, progress, seconds=seconds, rate_hz=rate_hz)
            findings = bench.run(peer_port)
    return _table(findings, seconds, rate_hz)


@contextmanager
def _caller() -> Generator[ProcessPoolExecutor]:
    """Yield a process that makes calls and nothing else, and has imported what it needs."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as caller:
        caller.submit(time.sleep, 0.0).result()
        yield caller


class _Bench:
    """The order of things: idle, then busy."""

    def __init__(
        self,
        ground: Ground,
        serving: Serving,
        caller: ProcessPoolExecutor,
        progress: Progress,
        *,
        seconds: float,
        rate_hz: float,
    ) -> None:
        self._ground = ground
        self._serving = serving
        self._caller = caller
        self._progress = progress
        self._seconds = seconds
        self._rate_hz = rate_hz

    def run(self, peer_port: int) -> _Findings:
        """Measure, stretch by stretch."""
        port = self._serving.port
        self._progress(0.1, "calling an idle station")
        idle = self._window(port, calls_of(self._ground.past_pass, Ground.PAST_JOB))
        self._progress(0.2, "arming new passes")
        armed_ms = [self._arm_and_end(f"short-{number}") for number in range(_ARMINGS)]
        self._progress(0.25, "waiting for the last of them")
        self._serving.client.await_pass(f"short-{_ARMINGS - 1}", timeout_s=_PATIENCE_S)
        self._serving.client.arm_pass(_PASS)
        self._progress(0.3, "calling a station that records and measures")
        calls = calls_of(_PASS, Ground.PAST_JOB)
        with self._readings() as readings:
            busy = self._window(port, calls)
        with self._ground.trains_waiting() as trains:
            self._progress(0.5, "calling a station that measures another train, too")
            with self._readings() as readings_behind:
                behind = self._window(port, calls_of(_PASS, trains.job_of(0)))
            self._progress(0.7, "calling the bare app instead")
            peer = self._window(peer_port, calls)
        closed = self._serving.client.finish_pass(_PASS, triggers={})
        return _Findings(
            idle,
            busy,
            behind,
            peer,
            armed_ms,
            readings.late_s,
            readings_behind.late_s,
            closed["recordings"][0],
            trains.measured,
        )

    def _readings(self) -> ReadingsSeen:
        return ReadingsSeen(self._serving.port, self._ground.key, _PASS)

    def _window(self, port: int, calls: tuple[Call, ...]) -> _Window:
        # The first calls of a process compile statements and start threads: not counted.
        warm_up_s = min(_WARM_UP_S, self._seconds)
        warm_up = Load(port, self._ground.key, calls, _WARM_UP_HZ, warm_up_s)
        self._caller.submit(drive, warm_up).result()
        load = Load(port, self._ground.key, calls, self._rate_hz, self._seconds)
        before = self._serving.core_s()
        driven = self._caller.submit(drive, load).result()
        after = self._serving.core_s()
        used = {part: after[part] - before[part] for part in after}
        return _Window(driven, {**used, "who calls": driven.core_s})

    def _arm_and_end(self, pass_id: str) -> float:
        """Return how long a new pass took to be armed, ms."""
        began_s = time.perf_counter()
        self._serving.client.arm_pass(pass_id)
        took_ms = 1e3 * (time.perf_counter() - began_s)
        self._serving.client.finish_pass(pass_id, triggers={})
        return took_ms


def calls_of(pass_id: str, job_id: str) -> tuple[Call, ...]:
    """Return what controllers and people call, and how often in a hundred calls."""
    return (
        Call("GET pass", "GET", f"/v1/passes/{pass_id}", 40.0),
        Call("PUT pass, again", "PUT", f"/v1/passes/{pass_id}", 20.0, body="{}"),
        Call("GET wheels", "GET", f"/v1/passes/{pass_id}/wheels", 5.0),
        Call("GET job", "GET", f"/v1/jobs/{job_id}", 15.0),
        Call("GET station", "GET", "/v1/station", 10.0),
        Call("GET measurements", "GET", "/v1/measurements", 5.0),
        Call("GET recordings", "GET", "/v1/recordings", 5.0),
    )


def _table(findings: _Findings, seconds: float, rate_hz: float) -> Table:
    rows = [_row("GET, all", "GET", findings)]
    rows += [_row(call.name, call.name, findings) for call in calls_of("", "")]
    rows += [
        _reading_row("a wheel's last frame to its reading", findings.late_s, findings.late_behind_s)
    ]
    recording = findings.recording
    notes = (
        f"{rate_hz:g} calls/s for {seconds:g} s each, at random moments, counted from when each "
        f"was due; {findings.busy.rate_hz:.0f} a second were answered. Shares of the calls, %: "
        f"{', '.join(f'{call.name} {call.share:g}' for call in calls_of('', ''))}.",
        "Busy: one sensor records at full rate, a wheel every half second, and the wheels are "
        "measured as they pass. Behind: a train of the past is measured too. The bare app, which "
        "answers every call with a constant, takes the calls of a station that is behind.",
        f"Recorded: {recording['recorded']} frames, lost {recording['lost']}, refused "
        f"{recording['refused']}; {findings.trains} trains of the past measured.",
        f"Processors, % of a core, busy: {_cores(findings.busy)}; behind: "
        f"{_cores(findings.behind)}.",
        f"A new pass, from the call to its sensors waiting: {min(findings.armed_ms):.0f} to "
        f"{max(findings.armed_ms):.0f} ms.",
    )
    return Table("Calls to a station, ms", rows, notes)


def _cores(window: _Window) -> str:
    percents = {
        part: 100.0 * used_s / window.driven.took_s for part, used_s in window.core_s.items()
    }
    return ", ".join(f"{part} {percent:.0f}" for part, percent in percents.items())


def _row(what: str, kind: str, findings: _Findings) -> dict[str, Value]:
    limit_ms = ASKED_PUT_MS if kind.startswith("PUT") else ASKED_GET_MS
    answers = findings.busy.of(kind)
    took_ms = [each.took_ms for each in answers]
    refused = sum(each.status != 200 for each in answers)
    return {
        "what": what,
        "count": len(took_ms),
        "p50": _percentile(took_ms, 50.0),
        "p99": _late(took_ms),
        "max": max(took_ms),
        "failed": refused,
        "asked": f"p99 <= {limit_ms:g}",
        "holds": bool(_late(took_ms) <= limit_ms) and refused == 0,
        "p99 idle": _late([each.took_ms for each in findings.idle.of(kind)]),
        "p99 behind": _late([each.took_ms for each in findings.behind.of(kind)]),
        "p99 bare app": _late([each.took_ms for each in findings.peer.of(kind)]),
    }


def _reading_row(
    name: str, late_s: Sequence[float], late_behind_s: Sequence[float]
) -> dict[str, Value]:
    late_ms = [1e3 * each for each in late_s]
    longest_ms = max(late_ms, default=math.inf)
    return {
        "what": name,
        "count": len(late_s),
        "p50": _percentile(late_ms, 50.0),
        "p99": _late(late_ms),
        "max": longest_ms,
        "failed": 0,
        "asked": f"max <= {ASKED_READING_MS:g}",
        "holds": bool(longest_ms <= ASKED_READING_MS),
        "p99 idle": "-",
        "p99 behind": 1e3 * _late(late_behind_s),
        "p99 bare app": "-",
    }


def _late(values: Sequence[float]) -> float:
    return _percentile(values, _LATE)


def _percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile; of nothing, what never came."""
    return float(np.percentile(values, percent)) if values else math.inf
