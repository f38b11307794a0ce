"""Looking for recordings, and for what was measured from one."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from sqlalchemy import ColumnElement, or_, select
from sqlalchemy.orm import Session

from station.store.lists import ALWAYS, Cursor, Page, Span, newest_page
from station.store.tables import Measurement, Recording, Replay, ReplayMeasurement

_REPLAYS_LOOKED_AT = 200


class RecordingKind(StrEnum):
    """What is looked for among recordings."""

    LOSSY = "lossy"
    """Frames are missing."""
    CUT_SHORT = "cut_short"
    """A crash had cut it short, and it was made whole."""
    UPLOADED = "uploaded"
    DELETED = "deleted"
    RUNNING = "running"


_OF_KIND: dict[RecordingKind, ColumnElement[bool]] = {
    RecordingKind.LOSSY: or_(Recording.lost > 0, Recording.refused > 0, ~Recording.complete),
    RecordingKind.CUT_SHORT: Recording.recovered.is_(True),
    RecordingKind.UPLOADED: Recording.sha256.is_not(None),
    RecordingKind.DELETED: Recording.deleted_at.is_not(None),
    RecordingKind.RUNNING: Recording.closed_at.is_(None),
}


@dataclass(frozen=True, slots=True)
class RecordingSearch:
    """Which recordings are looked for; what is None is any."""

    name_holds: str | None = None
    """A piece of its own name, or of that of its pass or session."""
    sensor: str | None = None
    kind: RecordingKind | None = None
    span: Span = ALWAYS


def recordings_found(
    session: Session, search: RecordingSearch, *, limit: int, before: Cursor | None = None
) -> Page[Recording]:
    """Return the recordings that are looked for, by when they were opened, the newest first."""
    query = select(Recording)
    if search.name_holds is not None:
        names = Recording.id, Recording.pass_id, Recording.session_id
        held = (name.icontains(search.name_holds, autoescape=True) for name in names)
        query = query.where(or_(*held))
    if search.sensor is not None:
        query = query.where(Recording.sensor == search.sensor)
    if search.kind is not None:
        query = query.where(_OF_KIND[search.kind])
    return newest_page(
        session,
        query,
        Recording.opened_at,
        Recording.id,
        limit=limit,
        before=before,
        span=search.span,
    )


def measured_from(session: Session, recording_id: str) -> Sequence[Measurement]:
    """Return all measurements of a recording's frames, in the order they were made."""
    return session.scalars(
        select(Measurement).where(Measurement.recording_id == recording_id).order_by(Measurement.id)
    ).all()


def measured_together_with(session: Session, recording: Recording) -> Sequence[Measurement]:
    """Return the wheels of its pass that its sensor saw with others of its rig, as it was recorded.

    Of each the one that was measured first; they are kept with a frame of another recording.  What
    was measured once more with other calibrations is not among them: a replay's are `replayed_as`.
    """
    if recording.pass_id is None or recording.rig_calibration_id is None:
        return []
    found = session.scalars(
        select(Measurement)
        .join(Recording, Measurement.recording_id == Recording.id)
        .where(Measurement.pass_id == recording.pass_id)
        .where(Measurement.calibration_id == Recording.calibration_id)
        .where(Measurement.rig_calibration_id == recording.rig_calibration_id)
        .where(Measurement.recording_id != recording.id)
        .order_by(Measurement.id)
    )
    firsts: dict[tuple[str, int], Measurement] = {}
    for row in found:
        if recording.sensor in row.wheel.get("sensors", ()):
            firsts.setdefault((row.recording_id, row.frame), row)
    return list(firsts.values())


def replays_of(session: Session, recording_id: str) -> Sequence[Replay]:
    """Return the replays of a recording among the last ones ordered, the newest first.

    Also those that have come to nothing, or not yet; older ones are in the list of replays.
    """
    newest = select(Replay).order_by(Replay.ordered_at.desc(), Replay.id.desc())
    return [
        row
        for row in session.scalars(newest.limit(_REPLAYS_LOOKED_AT))
        if any(recording_id in step for step in row.steps["steps"])
    ]


def replayed_as(session: Session, replay_id: str) -> Sequence[Measurement]:
    """Return all measurements that a replay came to, in the order they were made."""
    own = select(ReplayMeasurement.measurement_id).where(ReplayMeasurement.replay_id == replay_id)
    return session.scalars(
        select(Measurement).where(Measurement.id.in_(own)).order_by(Measurement.id)
    ).all()
