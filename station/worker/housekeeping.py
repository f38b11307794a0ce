"""Keeping the disk: what is to make way is deleted, what is seldom read is made smaller, as jobs.

Both are ordered by the worker itself when there is something to do.  Killed in the middle, a job
is taken up again: what is done already is found done.
"""

from datetime import timedelta

import structlog

from station.errors import StationError
from station.storage import compact_recording, due_deletions, due_for_compacting, tidy
from station.store import (
    Job,
    JobKind,
    JobState,
    add_job,
    end,
    pass_in_progress,
    the,
    unfinished_jobs,
)
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line

_SUBJECT = "recordings"
_log = structlog.get_logger()


def order_housekeeping(context: WorkContext) -> list[Job]:
    """Order what the disk needs now; a job that was ordered and has not ended is enough."""
    storage = context.settings.storage
    wanted: list[JobKind] = []
    if due_deletions(context.store, context.layout.root, storage, context.now()):
        wanted.append(JobKind.RETENTION)
    if _due_for_compacting(context):
        wanted.append(JobKind.COMPACT)
    ordered: list[Job] = []
    for kind in wanted:
        with context.store.change() as session:
            if all(job.kind != kind for job in unfinished_jobs(session)):
                name = f"{kind}.{context.now():%Y%m%dT%H%M%S%f}Z"
                ordered.append(add_job(session, name, kind, _SUBJECT, at=context.now()))
    return ordered


def _due_for_compacting(context: WorkContext) -> list[str]:
    days = context.settings.storage.compact_after_days
    if days is None or _busy(context):
        return []
    return due_for_compacting(context.store, context.now() - timedelta(days=days))


def _busy(context: WorkContext) -> bool:
    """Tell whether a train passes: its frames need the disk."""
    with context.store.look() as session:
        return pass_in_progress(session) is not None


def delete_what_is_due(context: WorkContext, job_id: str) -> None:
    """Do the job that deletes recordings."""
    if begin(context, job_id) is None:
        return
    storage, progress = context.settings.storage, JobProgress(context, job_id)
    try:
        tidy(context.store, context.layout.root, storage, context.now(), progress=progress)
    except JobCancelled:
        return
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        fail_housekeeping(context, job_id, _why(error, job_id))
        return
    _conclude(context, job_id)


def begin_compacting(context: WorkContext, job_id: str) -> list[str]:
    """Take the job up and return the recordings to compact; none where it has ended."""
    return [] if begin(context, job_id) is None else _due_for_compacting(context)


def compact_one(context: WorkContext, job_id: str, recording_id: str, place: int, of: int) -> None:
    """Compact one recording, unless the job has ended or a train passes: a later job takes it."""
    if _busy(context):
        return
    progress = JobProgress(context, job_id, first=place / of, last=(place + 1) / of)
    try:
        progress(0.0, recording_id)
        done = compact_recording(context.store, context.layout.root, recording_id, context.now())
    except JobCancelled:
        return
    except (OSError, StationError) as error:
        _log.warning("recording not compacted", recording=recording_id, why=str(error))
        return
    saved = sum(report.before_bytes - report.after_bytes for report in done.compacted)
    _log.info("recording compacted", recording=recording_id, saved_bytes=saved)


def conclude_compacting(context: WorkContext, job_id: str) -> None:
    """End the job."""
    _conclude(context, job_id)


def _conclude(context: WorkContext, job_id: str) -> None:
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is JobState.RUNNING:
            end(job, JobState.DONE, at=context.now())


def fail_housekeeping(context: WorkContext, job_id: str, why: str) -> None:
    """End a job that could not be done; the next look at the disk orders another."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state in {JobState.QUEUED, JobState.RUNNING}:
            end(job, JobState.FAILED, at=context.now(), error=why)


def _why(error: Exception, job_id: str) -> str:
    return f"the disk refuses: {error}" if isinstance(error, OSError) else one_line(error, job_id)
