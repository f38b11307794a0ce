"""A recalibration keeps out of the way of trains: it waits, and in the end gives up."""

import time
from collections.abc import Callable
from datetime import timedelta

from sqlalchemy.orm import Session

from station.errors import StationError
from station.store import Pass, PassState, Recalibration, pass_in_progress, report_progress
from station.store.watched import counts_by_state
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress

_LOOK_EVERY_S = 0.5


class PatienceOut(StationError):
    """Trains came for longer than the recalibration was to wait."""


class Quiet:
    """The progress of a step that stands aside while a pass is recorded or measured.

    Parameters
    ----------
    row
        The recalibration; its patience counts from when it was ordered, so that a worker started
        anew does not begin to wait anew.
    first, last
        The part of the job that the step is.
    """

    def __init__(
        self,
        context: WorkContext,
        row: Recalibration,
        *,
        first: float,
        last: float,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._context = context
        self._row = row
        self._first = first
        self._progress = JobProgress(context, row.job_id, first=first, last=last, clock=clock)
        self._sleep = sleep
        self._clock = clock
        self._looked_s = clock() - _LOOK_EVERY_S

    def __call__(self, fraction: float, what: str) -> None:
        """Note the progress of the step, and wait while a train is there.

        Raises
        ------
        JobCancelled
            If somebody cancelled the job.
        PatienceOut
            If trains come for too long.
        """
        if self._clock() - self._looked_s >= _LOOK_EVERY_S:
            self.ensure()
        self._progress(fraction, what)

    def pause(self, seconds: float) -> None:
        """Let time pass, for a mount to bring its target into the next pose."""
        self._sleep(seconds)

    def ensure(self) -> None:
        """Wait until no train is there; raises as a call does."""
        while (why := self._why_not()) is not None:
            self._give_up_in_time(why)
            self._say(f"waiting: {why}")
            self._sleep(_LOOK_EVERY_S)
        self._looked_s = self._clock()

    def _why_not(self) -> str | None:
        with self._context.store.look() as session:
            return _train_there(session)

    def _give_up_in_time(self, why: str) -> None:
        patience = timedelta(hours=self._context.settings.recalibration.patience_h)
        if self._context.now() - self._row.ordered_at > patience:
            raise PatienceOut(
                f"given up after {patience.total_seconds() / 3600.0:g} h, as {why}; the next one "
                "comes by the schedule, or order one"
            )

    def _say(self, what: str) -> None:
        with self._context.store.change() as session:
            if not report_progress(session, self._row.job_id, self._first, what):
                raise JobCancelled


def _train_there(session: Session) -> str | None:
    running = pass_in_progress(session)
    if running is not None:
        return f"pass {running.id} is {running.state}"
    measuring = counts_by_state(session, Pass).get(PassState.MEASURING, 0)
    return f"passes are being measured, {measuring}" if measuring else None
