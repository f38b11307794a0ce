"""Taking one picture once, though the call for it comes again after the process died in the middle.

Before a sensor exposes, the audit trail says which picture is being taken and how many frames each
sensor had: what has more by then has taken it.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.operations.collaborators import Station
from station.store import Action, Actor, AuditEntry, CalibrationSession, Recording, audit

_KIND = "calibration session"


@dataclass(frozen=True, slots=True)
class PictureBegun:
    """A picture that was to be taken."""

    picture: str
    """Its name; the call for it gives the same one when it comes again."""
    number: int
    """Which of the session's it is to be, from 1."""
    frames: dict[str, int]
    """How many frames each sensor had recorded before."""

    def counted(self, row: CalibrationSession) -> bool:
        """Tell whether the session has it."""
        return row.pictures >= self.number

    def missing(self, station: Station, recordings: Iterable[Recording]) -> list[str]:
        """Return the sensors that have not taken it yet."""
        return [
            each.sensor
            for each in recordings
            if _frames(station, each.sensor)
            < self.frames.get(each.sensor, 0) + _exposures(station, each.sensor)
        ]


def begun_before(session: Session, session_id: str, name: str) -> PictureBegun | None:
    """Return the picture of that name, where it is the last one begun in a calibration session.

    Of an earlier one nobody could tell which frames are its own.
    """
    told = session.scalar(
        select(AuditEntry.after)
        .where(AuditEntry.subject == session_id)
        .where(AuditEntry.kind == _KIND)
        .where(AuditEntry.action == Action.CAPTURE)
        .order_by(AuditEntry.id.desc())
        .limit(1)
    )
    begun = None if told is None else PictureBegun(**told)
    return begun if begun is not None and begun.picture == name else None


def begin_picture(
    station: Station, name: str, row: CalibrationSession, recordings: Iterable[Recording], by: Actor
) -> PictureBegun:
    """Say which picture is about to be taken.

    Raises
    ------
    CameraError
        If a sensor does not answer.
    """
    frames = {each.sensor: _frames(station, each.sensor) for each in recordings}
    begun = PictureBegun(name, row.pictures + 1, frames)
    now, told = station.now(), asdict(begun)
    with station.store.change() as session:
        audit(session, Action.CAPTURE, _KIND, row.id, by=by, at=now, after=told)
    return begun


def _frames(station: Station, sensor: str) -> int:
    return station.captures[sensor].status().recorded


def _exposures(station: Station, sensor: str) -> int:
    """Return how many frames a command takes of each pose."""
    settings = station.settings.sensor(sensor)
    return max(1, 0 if settings is None else len(settings.calibration_exposures))
