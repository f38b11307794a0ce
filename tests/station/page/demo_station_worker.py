"""The worker's jobs done here and now, by the worker's own functions; and the clock they go by."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from typing import Any

from station.operations import DataLayout, utc_now
from station.pipeline import (
    calibrate_rig_sources,
    calibrate_sources,
    measure_rig,
    measure_sources,
)
from station.settings import StationSettings
from station.store import JobKind, Store
from station.worker.calibrating import calibrate
from station.worker.calibrating_rig import calibrate_rig
from station.worker.context import Mathematics, WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step
from station.worker.recalibrating import recalibrate
from station.worker.replaying import begin_replay, conclude_replay, replay_step


class Clock:
    """A clock that somebody sets; it never runs backward."""

    def __init__(self, now: datetime) -> None:
        self._now = now

    def __call__(self) -> datetime:
        return self._now

    def ns(self) -> int:
        """Return the time as files have it."""
        return round(self().timestamp() * 1e9)

    def set(self, now: datetime) -> None:
        """Let time go by until a moment."""
        assert now >= self._now, f"{now} is before {self._now}: tell the story in its order"
        self._now = now

    def wait(self, **time: float) -> None:
        """Let so much time go by."""
        self._now += timedelta(**time)


class HostClock(Clock):
    """The clock of this host, which nobody sets."""

    def __init__(self) -> None:
        super().__init__(utc_now())

    def __call__(self) -> datetime:
        return utc_now()

    def set(self, now: datetime) -> None:
        raise AssertionError(f"{now}: nobody sets the clock of this host")

    def wait(self, **time: float) -> None:
        """Go on at once: what is shown is not to be waited for."""


def mathematics_by(clock: Clock) -> Mathematics:
    """Return what the worker calculates with; documents bear the time of the clock."""

    def dated(document: Any) -> Any:
        return document.model_copy(update={"created": clock()})

    def calibrating(function: Callable[..., Any]) -> Callable[..., Any]:
        def dated_outcome(*given: Any, **options: Any) -> Any:
            outcome = function(*given, **options)
            return replace(outcome, document=dated(outcome.document))

        return dated_outcome

    def measuring(function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *given, **options: dated(function(*given, **options))

    return Mathematics(
        calibrating(calibrate_sources),
        measuring(measure_sources),
        calibrating(calibrate_rig_sources),
        measuring(measure_rig),
    )


@dataclass
class WorkerHere:
    """The worker's place in the queue of jobs: does each as it is told of it."""

    settings: StationSettings
    store: Store
    layout: DataLayout
    clock: Clock
    resting: bool = False
    """Whether jobs are left lying, as by a worker that is busy with others."""
    cancelled: list[str] = field(default_factory=list)

    @property
    def context(self) -> WorkContext:
        """What the jobs work with."""
        return WorkContext(
            self.settings, self.store, self.layout, mathematics_by(self.clock), now=self.clock
        )

    def submit(self, kind: JobKind, job_id: str) -> None:
        if self.resting:
            return
        self.clock.wait(seconds=2.0)
        _JOBS[kind](self.context, job_id)

    def cancel(self, job_id: str) -> None:
        self.cancelled.append(job_id)


def _measure(context: WorkContext, job_id: str) -> None:
    steps = begin_measuring(context, job_id)
    results = [
        measure_step(context, job_id, step, place=place, of=len(steps))
        for place, step in enumerate(steps)
    ]
    conclude_measuring(context, job_id, results)


def _replay(context: WorkContext, job_id: str) -> None:
    for place in range(begin_replay(context, job_id)):
        replay_step(context, job_id, place)
    conclude_replay(context, job_id)


_JOBS: dict[JobKind, Callable[[WorkContext, str], None]] = {
    JobKind.CALIBRATE: calibrate,
    JobKind.CALIBRATE_RIG: calibrate_rig,
    JobKind.MEASURE: _measure,
    JobKind.RECALIBRATE: recalibrate,
    JobKind.REPLAY: _replay,
}
