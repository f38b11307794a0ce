"""Calls to a station while it records, with nobody looking at live pictures and with several."""

import multiprocessing
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
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
_LATE = 99.0


@dataclass(frozen=True, slots=True)
class _Stretch:
    """What was seen in one stretch of load.

    Attributes
    ----------
    core_s
        Of the API and what it started.
    """

    calls: Sequence[Answered]
    views: Sequence[Answered]
    core_s: float
    took_s: float

    def took_ms(self, kind: str, percent: float) -> float:
        """Return the percentile of how long the calls of a kind took."""
        return _percentile(_took_ms(self.calls, kind), percent)

    def failed(self, kind: str) -> int:
        """Return how many calls of a kind were not answered well."""
        return sum(each.status != 200 for each in self.calls if each.name.startswith(kind))


def bench_service_viewed(
    progress: Progress, *, seconds: float = 8.0, rounds: int = 5, rate_hz: float = _CALLS_HZ
) -> Table:
    """Call a station that records at full rate, in turns with people who look and without.

    Parameters
    ----------
    progress
        Told where the bench is.
    seconds
        Of each stretch of load.
    rounds
        Stretches of either kind; in turns, as a host's other work comes and goes.  One stall of a
        disk or host makes the 99th percentile of its stretch, hence the median of all is judged.
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
            seen: dict[bool, list[_Stretch]] = {False: [], True: []}
            for number in range(rounds):
                progress(0.2 + 0.8 * number / rounds, "calling, and looking")
                for looked in (False, True) if number % 2 else (True, False):
                    seen[looked].append(bench.window(seconds, looked=looked))
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

    def window(self, seconds: float, *, looked: bool) -> _Stretch:
        """Make one stretch; return what was seen."""
        before_s, began_s = self._serving.core_s()["API"], time.perf_counter()
        calls = self._drive(calls_of(_PASS, Ground.PAST_JOB), self._rate_hz, seconds)
        views = self._drive(_views(), _VIEWS_HZ, seconds) if looked else None
        called = calls.result().answers
        viewed = () if views is None else views.result().answers
        took_s = time.perf_counter() - began_s
        return _Stretch(called, viewed, self._serving.core_s()["API"] - before_s, took_s)

    def _drive(self, calls: tuple[Call, ...], rate_hz: float, seconds: float) -> Future[Driven]:
        load = Load(self._serving.port, self._ground.key, calls, rate_hz, seconds)
        return self._callers.submit(drive, load)


def _views() -> tuple[Call, ...]:
    path = f"/v1/sensors/{SENSOR}/view?max_width="
    return tuple(Call("view", "GET", f"{path}{width_px}", 1.0) for width_px in _WIDTHS_PX)


def _table(seen: Mapping[bool, Sequence[_Stretch]], recording: Answer, rate_hz: float) -> Table:
    alone, looked = seen[False], seen[True]
    rows = [_row(kind, alone, looked) for kind in ("GET", "PUT")]
    views = [view for stretch in looked for view in stretch.views]
    views_ms = _took_ms(views, "view")
    served = sum(each.status == 200 for each in views)
    notes = (
        f"{rate_hz:g} calls/s and, looked at, {_VIEWS_HZ:g} pictures/s with their stripes, while "
        "a sensor records at full rate and its wheels are measured as they pass; medians of "
        f"{len(looked)} stretches each, in turns, and of p99 the least and the most.",
        f"Pictures: {served} of {len(views)} served, p50 {_percentile(views_ms, 50.0):.0f} ms, "
        f"p99 {_percentile(views_ms, 99.0):.0f} ms.",
        f"The API and its viewing process, % of a core: {_core_percent(alone):.1f}, looked at "
        f"{_core_percent(looked):.1f}.",
        f"Recorded: {recording['recorded']} frames, lost {recording['lost']}, refused "
        f"{recording['refused']}.",
    )
    return Table("Calls to a station that is looked at, ms", rows, notes)


def _row(kind: str, alone: Sequence[_Stretch], looked: Sequence[_Stretch]) -> dict[str, Value]:
    late_alone_ms = [stretch.took_ms(kind, _LATE) for stretch in alone]
    late_ms = [stretch.took_ms(kind, _LATE) for stretch in looked]
    failed = sum(stretch.failed(kind) for stretch in (*alone, *looked))
    most_ms = _MOST_RATIO * float(np.median(late_alone_ms)) + _SLACK_MS
    return {
        "what": kind,
        "count": sum(len(_took_ms(stretch.calls, kind)) for stretch in looked),
        "p50": float(np.median([stretch.took_ms(kind, 50.0) for stretch in alone])),
        "p50 looked at": float(np.median([stretch.took_ms(kind, 50.0) for stretch in looked])),
        "p99": float(np.median(late_alone_ms)),
        "from, to": _from_to(late_alone_ms),
        "p99 looked at": float(np.median(late_ms)),
        "from, to, looked at": _from_to(late_ms),
        "failed": failed,
        "asked": f"p99 <= {_MOST_RATIO:g} of alone + {_SLACK_MS:g}",
        "holds": bool(np.median(late_ms) <= most_ms) and failed == 0,
    }


def _took_ms(answers: Sequence[Answered], kind: str) -> list[float]:
    return [each.took_ms for each in answers if each.name.startswith(kind)]


def _core_percent(seen: Sequence[_Stretch]) -> float:
    return 100.0 * sum(each.core_s for each in seen) / sum(each.took_s for each in seen)


def _from_to(values: Sequence[float]) -> str:
    return f"{min(values):.0f} to {max(values):.0f}"


def _percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile; of nothing, none."""
    return float(np.percentile(values, percent)) if values else float("nan")
