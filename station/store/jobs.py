"""The life of a job in the store: what the API shows and what the worker reports."""

from collections.abc import Sequence
from datetime import datetime
from enum import StrEnum

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.states import JOB, JobState
from station.store.tables import Job


class JobKind(StrEnum):
    """What a job does."""

    CALIBRATE = "calibrate"
    CALIBRATE_RIG = "calibrate_rig"
    MEASURE = "measure"
    RECALIBRATE = "recalibrate"
    MEASURE_AGAIN = "measure_again"
    REPLAY = "replay"
    RETENTION = "retention"
    COMPACT = "compact"


def add_job(session: Session, job_id: str, kind: JobKind, subject: str, *, at: datetime) -> Job:
    """Put a job into the list; the worker finds it there even if nobody tells it."""
    job = Job(
        id=job_id,
        kind=kind,
        subject=subject,
        state=JobState.QUEUED,
        progress=0.0,
        doing="waiting",
        created_at=at,
    )
    session.add(job)
    return job


def start(job: Job, *, at: datetime) -> None:
    """Say that the worker has taken the job up, perhaps not for the first time."""
    JOB.check(job.id, job.state, JobState.RUNNING)
    job.state = JobState.RUNNING
    job.started_at = job.started_at or at


def end(job: Job, state: JobState, *, at: datetime, error: str | None = None) -> None:
    """End a job: done, failed with one line of what happened, or cancelled."""
    JOB.check(job.id, job.state, state)
    job.state = state
    job.ended_at = at
    job.error = error
    job.doing = state.value
    if state is JobState.DONE:
        job.progress = 1.0


def report_progress(session: Session, job_id: str, fraction: float, doing: str) -> bool:
    """Note how far a running job is; False where it no longer runs, having been cancelled."""
    job = session.get(Job, job_id, with_for_update=True)
    if job is None or job.state is not JobState.RUNNING:
        return False
    job.progress = min(max(fraction, 0.0), 1.0)
    job.doing = doing
    return True


def unfinished_jobs(session: Session) -> Sequence[Job]:
    """Return the jobs that have not ended, oldest first."""
    return session.scalars(
        select(Job).where(Job.state.in_(JOB.unfinished)).order_by(Job.created_at)
    ).all()
