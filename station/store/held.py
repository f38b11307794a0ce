"""What holds the sensors now."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.states import SESSION, PassState
from station.store.tables import CalibrationSession, Pass, Recording

HELD = (PassState.ARMED, PassState.RECORDING)
"""States in which a pass holds the sensors."""


def passes_held(session: Session) -> Sequence[Pass]:
    """Return the passes that hold sensors, the oldest first; there should be one at most."""
    return session.scalars(select(Pass).where(Pass.state.in_(HELD)).order_by(Pass.opened_at)).all()


def paths_being_recorded(session: Session) -> set[str]:
    """Return where the passes and sessions that hold sensors are recorded."""
    of_passes = select(Recording.path).join(Pass, Recording.pass_id == Pass.id)
    of_sessions = select(Recording.path).join(
        CalibrationSession, Recording.session_id == CalibrationSession.id
    )
    return {
        *session.scalars(of_passes.where(Pass.state.in_(HELD))),
        *session.scalars(of_sessions.where(CalibrationSession.state.in_(SESSION.unfinished))),
    }


def pass_in_progress(session: Session) -> Pass | None:
    """Return the pass that holds the sensors, if there is one."""
    return session.scalar(select(Pass).where(Pass.state.in_(HELD)).limit(1))


def session_in_progress(session: Session, sensor: str) -> CalibrationSession | None:
    """Return the calibration session that holds a sensor, if there is one."""
    return session.scalar(
        select(CalibrationSession)
        .join(Recording, Recording.session_id == CalibrationSession.id)
        .where(Recording.sensor == sensor)
        .where(CalibrationSession.state.in_(SESSION.unfinished))
        .limit(1)
    )


def open_sessions(session: Session) -> Sequence[CalibrationSession]:
    """Return the calibration sessions not yet finished, oldest first."""
    return session.scalars(
        select(CalibrationSession)
        .where(CalibrationSession.state.in_(SESSION.unfinished))
        .order_by(CalibrationSession.opened_at)
    ).all()
