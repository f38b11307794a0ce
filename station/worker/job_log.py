"""Every line that a job logs names the job; that it began and how it ended are lines of its own."""

import time
from collections.abc import Callable
from functools import wraps

import structlog

from station.log_ids import about
from station.store import Job, JobKind
from station.worker.context import WorkContext
from station.worker.perseverance import persevering

_log = structlog.get_logger()
Workflow = Callable[[str], None]


def logged(context: WorkContext) -> Callable[[Workflow], Workflow]:
    """Return a decorator for the workflow of a job; it goes under that of the engine."""

    def decorate(workflow: Workflow) -> Workflow:
        @wraps(workflow)
        def logging_workflow(job_id: str) -> None:
            job = _job(context, job_id)
            kind = None if job is None else job.kind
            of_pass = job is not None and kind == JobKind.MEASURE
            with about(job=job_id, kind=kind, pass_id=job.subject if job and of_pass else None):
                _log.info("job taken up", subject=None if job is None else job.subject)
                began_s = time.monotonic()
                workflow(job_id)
                _note_end(_job(context, job_id), time.monotonic() - began_s)

        return logging_workflow

    return decorate


@persevering
def _job(context: WorkContext, job_id: str) -> Job | None:
    with context.store.look() as session:
        return session.get(Job, job_id)


def _note_end(job: Job | None, seconds: float) -> None:
    if job is not None:
        say = _log.info if job.error is None else _log.warning
        say("job ended", state=job.state.value, seconds=round(seconds, 2), error=job.error)
