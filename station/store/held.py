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
