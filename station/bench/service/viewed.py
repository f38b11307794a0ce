"""Calls to a station while it records, with nobody looking at live pictures and with several."""

import multiprocessing
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from station.bench.service.filled_store import Traffic
from station.bench.service.ground import SENSOR, Extent, Ground
from station.bench.service.load import calls_of
from station.bench.service.open_loop import Answered, Call, Driven, Load, drive
from station.bench.service.serving import Serving
from station.client import Answer
from station.progress import Progress
from station.tables import Table, Value

_CALLS_HZ, _VIEWS_HZ = 100.0, 20.0
"""Two people who look at two sensors, five times a second each."""
_WIDTHS_PX = (640, 641)
"""Pictures of one width do not serve for the other: as if they were of two sensors."""
_PASS = "viewed"
_WARM_UP_S = 4.0
_MOST_RATIO, _SLACK_MS = 1.25, 2.0


@dataclass(slots=True)
class _Seen:
    """What was seen in all windows of a kind."""

    calls: list[Answered] = field(default_factory=list)
    views: list[Answered] = field(default_factory=list)
    core_s: float = 0.0
    """Of the API and what it started."""
    took_s: float = 0.0

    def took_ms(self, kind: str) -> list[float]:
        """Return how long the calls of a kind took."""
        return [each.took_ms for each in self.calls if each.name.startswith(kind)]

    def failed(self, kind: str) -> int:
        """Return how many calls of a kind were not answered well."""
        return sum(each.status != 200 for each in self.calls if each.name.startswith(kind))

    @property
    def core_percent(self) -> float:
        """Share of a core that the API and what it started took."""
        return 100.0 * self.core_s / self.took_s


def bench_service_viewed(
    progress: Progress, *, seconds: float = 8.0, rounds: int = 4, rate_hz: float = _CALLS_HZ
) -> Table:
    """Call a station that records at full rate, in turns with people who look and without.

    Parameters
    ----------
    progress
        Told where the bench is.
    seconds
        Of each stretch of load.
    rounds
        Stretches of either kind; in turns, as a host's other work comes and goes.
    rate_hz
        Calls a second, beside those for pictures.
    """
    longest_pass_s = 4.0 * seconds * rounds + 60.0
    extent = Extent(Traffic(passes=10, axles=10), wheels=2, longest_pass_s=longest_pass_s)
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder, _callers() as callers:
        ground = Ground.prepared(Path(folder), extent, progress)
        with Serving(ground) as serving:
            serving.client.arm_pass(_PASS)
            bench = _Bench(ground, serving, callers, rate_hz)
            bench.window(_WARM_UP_S, looked=True)  # the viewing process begins
            seen = {False: _Seen(), True: _Seen()}
            for number in range(rounds):
                progress(0.2 + 0.8 * number / rounds, "calling, and looking")
                for looked in (False, True) if number % 2 else (True, False):
                    bench.window(seconds, looked=looked, into=seen[looked])
            closed = serving.client.finish_pass(_PASS, triggers={})
    return _table(seen, closed["recordings"][0], rate_hz)


@contextmanager
def _callers() -> Generator[ProcessPoolExecutor]:
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as callers:
        for started in [callers.submit(time.sleep, 0.1) for _ in range(2)]:
            started.result()
        yield callers


class _Bench:
    """Makes stretches of load."""

    def __init__(
        self, ground: Ground, serving: Serving, callers: ProcessPoolExecutor, rate_hz: float
    ) -> None:
        self._ground = ground
        self._serving = serving
        self._callers = callers
        self._rate_hz = rate_hz

    def window(self, seconds: float, *, looked: bool, into: _Seen | None = None) -> None:
        """Make one stretch, and add what was seen."""
        before_s, began_s = self._serving.core_s()["API"], time.perf_counter()
        calls = self._drive(calls_of(_PASS, Ground.PAST_JOB), self._rate_hz, seconds)
        views = self._drive(_views(), _VIEWS_HZ, seconds) if looked else None
        into = _Seen() if into is None else into
        into.calls += calls.result().answers
        into.views += () if views is None else views.result().answers
        into.took_s += time.perf_counter() - began_s
        into.core_s += self._serving.core_s()["API"] - before_s

    def _drive(self, calls: tuple[Call, ...], rate_hz: float, seconds: float) -> Future[Driven]:
        load = Load(self._serving.port, self._ground.key, calls, rate_hz, seconds)
        return self._callers.submit(drive, load)


def _views() -> tuple[Call, ...]:
    path = f"/v1/sensors/{SENSOR}/view?max_width="
    return tuple(Call("view", "GET", f"{path}{width_px}", 1.0) for width_px in _WIDTHS_PX)


def _table(seen: Mapping[bool, _Seen], recording: Answer, rate_hz: float) -> Table:
    alone, looked = seen[False], seen[True]
    rows = [_row(kind, alone, looked) for kind in ("GET", "PUT")]
    views_ms = [each.took_ms for each in looked.views]
    served = sum(each.status == 200 for each in looked.views)
    notes = (
        f"{rate_hz:g} calls/s and, looked at, {_VIEWS_HZ:g} pictures/s with their stripes, while "
        "a sensor records at full rate and its wheels are measured as they pass.",
        f"Pictures: {served} of {len(views_ms)} served, p50 {_percentile(views_ms, 50.0):.0f} ms, "
        f"p99 {_percentile(views_ms, 99.0):.0f} ms.",
        f"The API and its viewing process, % of a core: {alone.core_percent:.1f}, looked at "
        f"{looked.core_percent:.1f}.",
        f"Recorded: {recording['recorded']} frames, lost {recording['lost']}, refused "
        f"{recording['refused']}.",
    )
    return Table("Calls to a station that is looked at, ms", rows, notes)


def _row(kind: str, alone: _Seen, looked: _Seen) -> dict[str, Value]:
    alone_ms, looked_ms = alone.took_ms(kind), looked.took_ms(kind)
    late_alone_ms, late_ms = _percentile(alone_ms, 99.0), _percentile(looked_ms, 99.0)
    failed = alone.failed(kind) + looked.failed(kind)
    return {
        "what": kind,
        "count": len(looked_ms),
        "p50": _percentile(alone_ms, 50.0),
        "p50 looked at": _percentile(looked_ms, 50.0),
        "p99": late_alone_ms,
        "p99 looked at": late_ms,
        "failed": failed,
        "asked": f"p99 <= {_MOST_RATIO:g} of alone + {_SLACK_MS:g}",
        "holds": bool(late_ms <= _MOST_RATIO * late_alone_ms + _SLACK_MS) and failed == 0,
    }


def _percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile; of nothing, none."""
    return float(np.percentile(values, percent)) if values else float("nan")
