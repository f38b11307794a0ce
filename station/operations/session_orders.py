"""What is asked of a calibration session, and what is handed out of one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from calib import Target
from station.errors import StateConflict
from station.store import CalibrationSession, Recording, SessionState, recordings_of


@dataclass(frozen=True, slots=True)
class SessionOrder:
    """What pictures are to be taken with: a sensor, or all of a rig; and of which boards.

    Attributes
    ----------
    target
        The board; of a rig, that of the sensors without one of their own.
    targets
        The boards of single sensors of a rig.
    """

    target: Target
    sensor: str | None = None
    rig: str | None = None
    targets: Mapping[str, Target] | None = None

    @property
    def targets_kept(self) -> dict[str, str] | None:
        """The boards of single sensors as the store keeps them."""
        own = self.targets or {}
        return {name: str(target) for name, target in own.items()} or None


@dataclass(frozen=True, slots=True)
class SessionView:
    """A calibration session and what it recorded."""

    row: CalibrationSession
    recordings: Sequence[Recording]


def session_view(session: Session, row: CalibrationSession) -> SessionView:
    """Return a session as it stands."""
    return SessionView(row, recordings_of(session, row))


def ensure_same_order(present: CalibrationSession, order: SessionOrder) -> CalibrationSession:
    """Return the session that a call to open one names once more.

    Raises
    ------
    StateConflict
        If the call asks for another one, or the session has failed.
    """
    wanted = (order.sensor, order.rig, str(order.target), order.targets_kept)
    if (present.sensor, present.rig, present.target, present.targets) != wanted:
        of = f"rig {present.rig}" if present.sensor is None else f"sensor {present.sensor}"
        raise StateConflict(
            f"calibration session {present.id} is of {of} and target "
            f"{present.target}; give a new session a new id",
            state=present.state,
        )
    if present.state is SessionState.FAILED:
        raise StateConflict(
            f"calibration session {present.id} is {present.state} ({present.reason}); "
            "open a new one under a new id",
            state=present.state,
        )
    return present
