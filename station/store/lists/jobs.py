"""Jobs, and the recalibrations and replays that they work on, the newest first."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.lists.paging import Cursor, Page, newest_page
from station.store.states import JobState
from station.store.tables import Job, Recalibration, Replay


def jobs_page(
    session: Session,
    *,
    limit: int,
    before: Cursor | None = None,
    state: JobState | None = None,
    kind: str | None = None,
    subject: str | None = None,
) -> Page[Job]:
    """Return jobs by when they were ordered."""
    query = select(Job)
    if state is not None:
        query = query.where(Job.state == state)
    if kind is not None:
        query = query.where(Job.kind == kind)
    if subject is not None:
        query = query.where(Job.subject == subject)
    return newest_page(session, query, Job.created_at, Job.id, limit=limit, before=before)


def recalibrations_page(
    session: Session, sensor: str, *, limit: int, before: Cursor | None = None
) -> Page[Recalibration]:
    """Return a sensor's recalibrations, the newest first, from those older than the key."""
    query = select(Recalibration).where(Recalibration.sensor == sensor)
    return newest_page(
        session, query, Recalibration.ordered_at, Recalibration.id, limit=limit, before=before
    )


def replays_page(
    session: Session, *, limit: int, before: Cursor | None = None, pass_id: str | None = None
) -> Page[Replay]:
    """Return replays by when they were ordered."""
    query = select(Replay)
    if pass_id is not None:
        query = query.where(Replay.pass_id == pass_id)
    return newest_page(session, query, Replay.ordered_at, Replay.id, limit=limit, before=before)
