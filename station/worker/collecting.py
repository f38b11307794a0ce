"""What a recalibration is made from: new calibration sessions, or one that the station takes."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store import (
    Calibration,
    CalibrationSession,
    Recalibration,
    Recording,
    SessionState,
    the,
)
from station.store.recalibrations import recordings_taken
from station.worker.capturing import capture_session
from station.worker.context import WorkContext
from station.worker.quiet import Quiet


@dataclass(frozen=True, slots=True)
class Shown:
    """A recording of a calibration session, and the target it shows."""

    recording: Recording
    target: str
    session: str


def collect(context: WorkContext, row: Recalibration, quiet: Quiet) -> None:
    """Note in the row what is taken: recordings of one target, and of the reference piece."""
    if row.taken is not None and "recordings" in row.taken:
        return
    settings = context.settings.recalibration
    piece = settings.of(row.sensor).piece
    prefix = None if piece is None else piece.sessions
    target, piece_shown = _there(context, row, prefix)
    remarks: list[str] = []
    if not target and settings.of(row.sensor).capture is not None:
        remarks += capture_session(context, row, quiet)
        target, piece_shown = _there(context, row, prefix)
    with context.store.change() as session:
        found = the(session, Recalibration, row.id)
        found.taken = {
            "recordings": [each.recording.id for each in target],
            "target": target[0].target if target else None,
            "piece": [each.recording.id for each in piece_shown],
        }
        found.pictures_at = min(
            (each.recording.opened_at for each in target or piece_shown), default=None
        )
        found.findings = {**found.findings, "remarks": remarks}


def _there(
    context: WorkContext, row: Recalibration, prefix: str | None
) -> tuple[list[Shown], list[Shown]]:
    """Return what shows the target, and what shows the reference piece."""
    oldest = timedelta(hours=context.settings.recalibration.gates.oldest_pictures_h)
    with context.store.look() as session:
        shown = _of_sessions(session, row.sensor)
        fresh = [each for each in shown if each.recording.opened_at >= context.now() - oldest]
        of_piece = [each for each in fresh if _is_of_piece(each, prefix)]
        if row.taken is not None:
            named = set(row.taken["named"])
            target = [each for each in shown if each.recording.id in named]
        else:
            since, used = _already(session, row)
            target = [
                each
                for each in fresh
                if each.recording.opened_at > since
                and each.recording.id not in used
                and not _is_of_piece(each, prefix)
            ]
    # The newest alone: what it says of the sensor is not to be mixed with what was before.
    return _of_newest_target(target), of_piece[-1:]


def _is_of_piece(shown: Shown, prefix: str | None) -> bool:
    return prefix is not None and shown.session.startswith(prefix)


def _of_newest_target(shown: Sequence[Shown]) -> list[Shown]:
    return [each for each in shown if each.target == shown[-1].target]


def _of_sessions(session: Session, sensor: str) -> list[Shown]:
    """Return the recordings of a sensor's finished calibration sessions, oldest first."""
    rows = session.execute(
        select(Recording, CalibrationSession)
        .join(CalibrationSession, Recording.session_id == CalibrationSession.id)
        .where(Recording.sensor == sensor)
        .where(CalibrationSession.state == SessionState.RECORDED)
        .where(Recording.recorded > 0)
        .where(Recording.deleted_at.is_(None))
        .order_by(Recording.opened_at, Recording.id)
    )
    return [
        Shown(recording, (owner.targets or {}).get(sensor, owner.target), owner.id)
        for recording, owner in rows
    ]


def _already(session: Session, row: Recalibration) -> tuple[datetime, set[str]]:
    """Return since when pictures are new, and which have been taken already."""
    used = recordings_taken(session, row.sensor)
    if row.present_id is None:
        return datetime.min.replace(tzinfo=row.ordered_at.tzinfo), used
    present = the(session, Calibration, row.present_id)
    return present.created_at, used | set(present.recording_ids["recordings"])
