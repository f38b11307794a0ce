"""Passes, calibration sessions and their recordings, the newest first."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from operator import attrgetter

from sqlalchemy import select
from sqlalchemy.orm import InstrumentedAttribute, Session

from station.store.lists.paging import ALWAYS, Cursor, Page, Span, newest_page
from station.store.states import PassState
from station.store.tables import AxleWheel, CalibrationSession, Pass, Recording


def passes_page(
    session: Session,
    *,
    limit: int,
    before: Cursor | None = None,
    span: Span = ALWAYS,
    state: PassState | None = None,
    train: str | None = None,
    wheelset: str | None = None,
    id_holds: str | None = None,
    train_holds: str | None = None,
) -> Page[Pass]:
    """Return passes by when they were opened; of a `wheelset`, those that it was placed in.

    Of `id_holds` and `train_holds` those that have the text somewhere in their id, or in the name
    of their train, in small or capital letters.
    """
    query = select(Pass)
    if id_holds is not None:
        query = query.where(Pass.id.icontains(id_holds, autoescape=True))
    if train_holds is not None:
        query = query.where(Pass.train.icontains(train_holds, autoescape=True))
    if state is not None:
        query = query.where(Pass.state == state)
    if train is not None:
        query = query.where(Pass.train == train)
    if wheelset is not None:
        of_it = select(AxleWheel.pass_id).where(AxleWheel.wheelset == wheelset)
        query = query.where(Pass.id.in_(of_it))
    return newest_page(
        session, query, Pass.opened_at, Pass.id, limit=limit, before=before, span=span
    )


def recordings_by_pass(
    session: Session, passes: Iterable[Pass]
) -> Mapping[str, Sequence[Recording]]:
    """Return the recordings of passes, by the pass, each ordered by sensor."""
    return _by_owner(session, Recording.pass_id, [row.id for row in passes])


def recordings_page(
    session: Session,
    *,
    limit: int,
    before: Cursor | None = None,
    span: Span = ALWAYS,
    sensor: str | None = None,
    pass_id: str | None = None,
    session_id: str | None = None,
) -> Page[Recording]:
    """Return recordings by when they were opened."""
    query = select(Recording)
    if sensor is not None:
        query = query.where(Recording.sensor == sensor)
    if pass_id is not None:
        query = query.where(Recording.pass_id == pass_id)
    if session_id is not None:
        query = query.where(Recording.session_id == session_id)
    return newest_page(
        session, query, Recording.opened_at, Recording.id, limit=limit, before=before, span=span
    )


def sessions_page(
    session: Session, *, limit: int, before: Cursor | None = None, sensor: str | None = None
) -> Page[CalibrationSession]:
    """Return calibration sessions by when they were opened; of a sensor, a rig's of it too."""
    query = select(CalibrationSession)
    if sensor is not None:
        of_it = select(Recording.session_id).where(Recording.sensor == sensor)
        query = query.where(CalibrationSession.id.in_(of_it))
    return newest_page(
        session,
        query,
        CalibrationSession.opened_at,
        CalibrationSession.id,
        limit=limit,
        before=before,
    )


def recordings_by_session(
    session: Session, sessions: Iterable[CalibrationSession]
) -> Mapping[str, Sequence[Recording]]:
    """Return the recordings of calibration sessions, by the session, each ordered by sensor."""
    return _by_owner(session, Recording.session_id, [row.id for row in sessions])


def _by_owner(
    session: Session, owner: InstrumentedAttribute[str | None], wanted: Sequence[str]
) -> Mapping[str, Sequence[Recording]]:
    found = session.scalars(
        select(Recording).where(owner.in_(wanted)).order_by(owner, Recording.sensor)
    )
    return {name: list(own) for name, own in groupby(found, key=attrgetter(owner.key))}
