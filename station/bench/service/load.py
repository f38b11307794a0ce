"""Calls at a steady rate while a train is recorded and others are measured."""

import multiprocessing
import statistics
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from station.bench.service.filled_store import Traffic
from station.bench.service.ground import SENSOR, Extent, Ground
from station.bench.service.open_loop import Answered, Call, Driven, Load, drive
from station.bench.service.peer_app import served_peer
from station.bench.service.serving import Serving
from station.client import Answer
from station.progress import Progress
from station.tables import Table, Value

ASKED_GET_MS, ASKED_PUT_MS = 20.0, 50.0
_RATE_HZ = 200.0
_PASS = "running"
_ARMINGS = 5
_SETTLE_S = 2.0
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

    def of(self, name: str) -> list[Answered]:
        """Return the calls of one kind."""
        return [each for each in self.driven.answers if each.name == name]

    @property
    def rate_hz(self) -> float:
        """Calls answered a second."""
        return len(self.driven.answers) / self.driven.took_s


@dataclass(frozen=True, slots=True)
class _Findings:
    """All that was seen of the station."""

    idle: _Window
    busy: _Window
    peer: _Window
    armed_ms: Sequence[float]
    armed_busy_ms: float
    recording: Answer


def bench_service(
    progress: Progress, *, seconds: float = 30.0, rate_hz: float = _RATE_HZ, wheels: int = 100
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
        longest_pass_s=3.0 * seconds + 30.0,
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
        self._progress(0.1, "calling an idle station")
        idle = self._window(self._serving.port, calls_of(self._ground.past_pass, Ground.PAST_JOB))
        self._progress(0.3, "arming")
        armed_ms = [self._arm_and_end(f"short-{number}") for number in range(_ARMINGS)]
        self._ground.let_trains_wait(round(self._seconds))
        armed_busy_ms = self._arm(_PASS)
        time.sleep(_SETTLE_S)
        self._progress(0.5, "calling a busy station")
        calls = calls_of(_PASS, Ground.WAITING_JOB)
        busy = self._window(self._serving.port, calls)
        self._progress(0.8, "calling the bare app")
        peer = self._window(peer_port, calls)
        closed = self._serving.client.finish_pass(_PASS, triggers={})
        return _Findings(idle, busy, peer, armed_ms, armed_busy_ms, closed["recordings"][0])

    def _window(self, port: int, calls: tuple[Call, ...]) -> _Window:
        # The first calls of a process compile statements and start threads: not counted.
        self._caller.submit(
            drive, Load(port, self._ground.key, calls, _WARM_UP_HZ, _WARM_UP_S)
        ).result()
        load = Load(port, self._ground.key, calls, self._rate_hz, self._seconds)
        before = self._serving.core_s()
        driven = self._caller.submit(drive, load).result()
        after = self._serving.core_s()
        used = {part: after[part] - before[part] for part in after}
        return _Window(driven, {**used, "who calls": driven.core_s})

    def _arm(self, pass_id: str) -> float:
        began_s = time.perf_counter()
        self._serving.client.arm_pass(pass_id)
        return 1e3 * (time.perf_counter() - began_s)

    def _arm_and_end(self, pass_id: str) -> float:
        took_ms = self._arm(pass_id)
        self._serving.client.finish_pass(pass_id, triggers={})
        self._serving.client.await_pass(pass_id, timeout_s=60.0)
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
    names = [call.name for call in calls_of("", "")]
    rows = [_row(name, findings) for name in names]
    recording = findings.recording
    cores = [
        f"{part} {100.0 * used / findings.busy.driven.took_s:.0f}"
        for part, used in findings.busy.core_s.items()
    ]
    notes = (
        f"{rate_hz:g} calls/s for {seconds:g} s each, at random moments; answered "
        f"{findings.busy.rate_hz:.0f} a second.",
        f"Recorded at {SENSOR}: {recording['recorded']} frames, lost {recording['lost']}, "
        f"refused {recording['refused']}.",
        f"Processors while busy, % of a core: {', '.join(cores)}.",
        f"A new pass, armed and recording: {statistics.median(findings.armed_ms):.0f} ms idle, "
        f"{findings.armed_busy_ms:.0f} ms busy.",
    )
    return Table("Calls to a station that records and measures, ms", rows, notes)


def _row(name: str, findings: _Findings) -> dict[str, Value]:
    asked_ms = ASKED_PUT_MS if name.startswith("PUT") else ASKED_GET_MS
    took_ms = [each.took_ms for each in findings.busy.of(name)]
    late_ms = _late(findings.busy.of(name))
    refused = sum(each.status != 200 for each in findings.busy.of(name))
    return {
        "call": name,
        "calls": len(took_ms),
        "p50": float(np.median(took_ms)),
        "p99": late_ms,
        "max": max(took_ms),
        "refused": refused,
        "p99 idle": _late(findings.idle.of(name)),
        "p99 bare app": _late(findings.peer.of(name)),
        "asked": f"p99 <= {asked_ms:g}",
        "holds": bool(late_ms <= asked_ms) and refused == 0,
    }


def _late(answers: Sequence[Answered]) -> float:
    return float(np.percentile([each.took_ms for each in answers], _LATE))
