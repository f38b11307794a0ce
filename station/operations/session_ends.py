"""The end of a calibration session, whoever ended it; as with a pass, who did is written first."""

from station.operations.closing import close_all, note
from station.operations.collaborators import Station
from station.operations.session_orders import SessionView, session_view
from station.store import (
    SESSION,
    STATION,
    Action,
    Actor,
    CalibrationSession,
    EndedBy,
    SessionState,
    audit,
    recordings_of,
    the,
)


def note_session_end(
    station: Station,
    session_id: str,
    ended_by: EndedBy,
    why: str | None = None,
    *,
    by: Actor = STATION,
) -> bool:
    """Write down who ends a session; False where it has ended, or is ending."""
    with station.store.change() as session:
        row = the(session, CalibrationSession, session_id)
        if row.state not in SESSION.unfinished or row.ended_by is not None:
            return False
        row.ended_by, row.reason = ended_by, why
        kind, told = "calibration session", {"ended_by": ended_by.value, "why": why}
        audit(session, Action.FINISH, kind, session_id, by=by, at=station.now(), after=told)
        return True


def end_session(station: Station, session_id: str) -> SessionView:
    """Close a session whose end is written down; return it as it then is."""
    view = _view(station, session_id)
    if view.row.state not in SESSION.unfinished:
        return view
    return close_session(station, session_id, view.row.reason)


def close_session(station: Station, session_id: str, reason: str | None) -> SessionView:
    """Close the recordings of a session and account for its pictures."""
    view = _view(station, session_id)
    expected = _expected(station, view)
    accounts = close_all(station, view.recordings, expected)
    with station.store.change() as session:
        row = the(session, CalibrationSession, session_id)
        if row.state not in SESSION.unfinished:  # the worker closes its sessions itself
            return session_view(session, row)
        row.finished_at = station.now()
        for recording in recordings_of(session, row):
            recording.closed_at = row.finished_at
            note(recording, accounts[recording.id], expected[recording.sensor])
        pictures = any(closed.recorded for closed in accounts.values())
        row.state, row.reason = _end_of(row, reason, pictures=pictures)
        return session_view(session, row)


def _view(station: Station, session_id: str) -> SessionView:
    with station.store.look() as session:
        return session_view(session, the(session, CalibrationSession, session_id))


def _expected(station: Station, view: SessionView) -> dict[str, int | None]:
    """Return how many frames were commanded; the capture process counts those of sequences."""
    sensors = [recording.sensor for recording in view.recordings]
    return {
        sensor: None if _takes_sequences(station, sensor) else view.row.pictures
        for sensor in sensors
    }


def _takes_sequences(station: Station, sensor_id: str) -> bool:
    sensor = station.settings.sensor(sensor_id)
    return sensor is not None and bool(sensor.calibration_exposures)


def _end_of(
    row: CalibrationSession, reason: str | None, *, pictures: bool
) -> tuple[SessionState, str | None]:
    """Return how a session ends, and why it says it does."""
    if row.ended_by is EndedBy.CONTROLLER or (row.ended_by is not None and pictures):
        wanted = SessionState.RECORDED
    else:
        wanted = SessionState.FAILED
        reason = reason if row.ended_by is None else f"{reason}; no picture had been taken"
    SESSION.check(row.id, row.state, wanted)
    return wanted, reason
