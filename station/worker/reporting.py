"""How a running job tells where it is, learns that it was cancelled, and says why it failed."""

import time
from collections.abc import Callable

import structlog

from calib import CalibError
from station.errors import StationError
from station.store import Job, JobState, report_progress, start, the
from station.worker.context import WorkContext
from station.worker.perseverance import PASSING

_log = structlog.get_logger()
_PAUSE_S = 0.2


class JobCancelled(Exception):
    """Somebody cancelled the job: not a failure, hence no StationError that a step may catch."""


class JobProgress:
    """Writes a job's progress into the store, a few times a second at most."""

    def __init__(
        self,
        context: WorkContext,
        job_id: str,
        *,
        first: float = 0.0,
        last: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._context = context
        self._job_id = job_id
        self._first = first
        self._span = last - first
        self._clock = clock
        self._due_s = clock()

    def __call__(self, fraction: float, what: str) -> None:
        """Note the progress of this part of the job.

        Raises
        ------
        JobCancelled
            If somebody cancelled the job.
        """
        if self._clock() < self._due_s:
            return
        self._due_s = self._clock() + _PAUSE_S
        with self._context.store.change() as session:
            runs = report_progress(session, self._job_id, self._first + self._span * fraction, what)
        if not runs:
            raise JobCancelled


def begin(context: WorkContext, job_id: str) -> Job | None:
    """Take a job up, perhaps again after a crash; None where it has ended meanwhile."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state not in {JobState.QUEUED, JobState.RUNNING}:
            return None
        start(job, at=context.now())
        return job


def one_line(error: Exception, job_id: str) -> str:
    """Return what to tell of an error; the details of one that nobody foresaw go to the log.

    Raises
    ------
    StoreUnusable, BrokenExecutor
        Again, where it is one: there is nothing to tell of the work, see `persevering`.
    """
    if isinstance(error, PASSING):
        raise error
    if isinstance(error, (StationError, CalibError)):
        return str(error)
    _log.error("job failed unexpectedly", job=job_id, exc_info=error)
    return f"internal error ({type(error).__name__}); the worker's log has it under job {job_id}"
