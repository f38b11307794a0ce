"""Long work: where it is, following it, ending it."""

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Query
from fastapi.concurrency import run_in_threadpool
from fastapi.sse import EventSourceResponse, ServerSentEvent

from station.api.actors import By
from station.api.answers import JobModel
from station.api.callers import Operator, Reader
from station.api.list_answers import JobsPage
from station.api.paging import Before, cursor_in
from station.api.parts import Parts, PartsOf
from station.api.remembered import from_the_store
from station.api.requests import CallersId, IdInPath, Limit
from station.operations import cancel_job
from station.store import JOB, Job, JobKind, JobState, the
from station.store.lists import jobs_page

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_ONE = "/{job_id}"
_LOOK_EVERY_S = 0.2
_SAY_SOMETHING_EVERY_S = 10.0


def _job(job_id: IdInPath, parts: PartsOf) -> JobModel:
    return _look_up(parts, job_id)


def _look_up(parts: Parts, job_id: str) -> JobModel:
    with parts.station.store.look() as session:
        return JobModel.of(the(session, Job, job_id))


JobOf = Annotated[JobModel, Depends(_job)]


@router.get("")
@from_the_store
def list_jobs(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    state: JobState | None = None,
    kind: JobKind | None = None,
    subject: Annotated[
        CallersId | None, Query(description="The pass, calibration or else it works on.")
    ] = None,
) -> JobsPage:
    """Return jobs, the newest first."""
    with parts.station.store.look() as session:
        page = jobs_page(
            session,
            limit=limit,
            before=cursor_in(before),
            state=state,
            kind=kind,
            subject=subject,
        )
    return JobsPage.of(page)


@router.get(_ONE)
@from_the_store
def get_job(job: JobOf, _: Reader) -> JobModel:
    """Return the state and progress of a job."""
    return job


@router.get(f"{_ONE}/events", response_class=EventSourceResponse)
async def follow_job(job: JobOf, parts: PartsOf, _: Reader) -> AsyncIterator[ServerSentEvent]:
    """Send the job whenever it changes, until it has ended."""
    yield ServerSentEvent(event="job", data=job)
    silent_s = 0.0
    while not JOB.ended(job.state):
        await asyncio.sleep(_LOOK_EVERY_S)
        now = await run_in_threadpool(_look_up, parts, job.id)
        silent_s += _LOOK_EVERY_S
        if now != job:
            job, silent_s = now, 0.0
            yield ServerSentEvent(event="job", data=job)
        elif silent_s >= _SAY_SOMETHING_EVERY_S:
            silent_s = 0.0
            yield ServerSentEvent(comment="still at it")


@router.delete(_ONE)
def delete_job(job_id: IdInPath, parts: PartsOf, _: Operator, by: By) -> JobModel:
    """Cancel a job; what it worked on stays usable."""
    return JobModel.of(cancel_job(parts.station, job_id, by=by))
