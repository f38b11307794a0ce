"""Pictures for a calibration, taken one by one while somebody moves the target."""

from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock

from sqlalchemy.orm import Session

from calib import Target
from station.capture import Trigger
from station.errors import StateConflict, StationError
from station.operations.arming import (
    arm,
    calibration_in_force,
    ensure_sensors_free,
    ensure_space_for_session,
)
from station.operations.closing import close_all, note
from station.operations.collaborators import Station
from station.operations.sensors import sensor_given
from station.store import (
    SESSION,
    CalibrationSession,
    Recording,
    SessionState,
    open_sessions,
    recordings_of,
    the,
)


@dataclass(frozen=True, slots=True)
class SessionView:
    """A calibration session and what it recorded."""

    row: CalibrationSession
    recordings: Sequence[Recording]


class Sessions:
    """The desk for calibration sessions."""

    def __init__(self, station: Station) -> None:
        self._station = station
        # Taking a picture and closing exclude each other, so that no picture misses the file.
        self._camera = Lock()

    def view(self, session_id: str) -> SessionView:
        """Return a calibration session.

        Raises
        ------
        NotFound
            If there is none of that id.
        """
        with self._station.store.look() as session:
            return _view(session, the(session, CalibrationSession, session_id))

    def open(self, session_id: str, *, sensor: str, target: Target) -> tuple[SessionView, bool]:
        """Ready a sensor for pictures on command; return the session and whether it is new.

        Raises
        ------
        InputUnusable
            If the station has no such sensor.
        StateConflict
            If another recording runs, or the id is of another session.
        DiskFull
            If its pictures would not fit on the disk; the id stays free.
        CameraError, RecordingError
            If the sensor cannot record; the session has then failed.
        """
        settings = sensor_given(self._station.settings, sensor)
        with self._station.store.change() as session:
            present = session.get(CalibrationSession, session_id)
            if present is not None:
                return _view(session, _ensure_same(present, sensor, target)), False
            ensure_sensors_free(session, [settings], f"calibration session {session_id}")
            ensure_space_for_session(self._station, settings)
            recording = self._add(session, session_id, sensor, target)
        try:
            arm(self._station, recording, owner=session_id, trigger=Trigger.SOFTWARE)
        except StationError as error:
            self._close(session_id, SessionState.FAILED, f"not armed: {error}")
            raise
        with self._station.store.change() as session:
            row = the(session, CalibrationSession, session_id)
            _step(row, SessionState.OPEN)
            return _view(session, row), True

    def take_picture(self, session_id: str) -> SessionView:
        """Take one picture and return when it is recorded.

        Raises
        ------
        NotFound
            If there is no such session.
        StateConflict
            If it is not open.
        CameraError, RecordingError
            If the picture does not arrive.
        """
        with self._camera:
            row = self.view(session_id).row
            if row.state is not SessionState.OPEN:
                raise StateConflict(
                    f"calibration session {session_id} is {row.state}; "
                    "pictures are taken while it is open",
                    state=row.state,
                )
            self._station.captures[row.sensor].trigger()
            with self._station.store.change() as session:
                row = the(session, CalibrationSession, session_id)
                row.pictures += 1
                return _view(session, row)

    def finish(self, session_id: str) -> SessionView:
        """Close the recording of a session; one that is closed stays as it is.

        Raises
        ------
        NotFound
            If there is no such session.
        StateConflict
            If it is not yet armed, or has failed.
        """
        with self._camera:
            view = self.view(session_id)
            if view.row.state is SessionState.RECORDED:
                return view
            if view.row.state is not SessionState.OPEN:
                SESSION.check(session_id, view.row.state, SessionState.OPEN)
            return self._close(session_id, SessionState.RECORDED)

    def take_up(self) -> None:
        """Close, after a start, the sessions that no capture process still holds open."""
        with self._station.store.look() as session:
            rows = open_sessions(session)
        for row in rows:
            if not self._still_open(row):
                with self._camera:
                    self._close(row.id, SessionState.RECORDED, "the station stopped meanwhile")

    def _add(self, session: Session, session_id: str, sensor: str, target: Target) -> Recording:
        now = self._station.now()
        session.add(
            CalibrationSession(
                id=session_id,
                state=SessionState.ARMED,
                sensor=sensor,
                target=str(target),
                pictures=0,
                opened_at=now,
            )
        )
        recording = Recording(
            id=f"session.{session_id}.{sensor}",
            sensor=sensor,
            session_id=session_id,
            path=str(self._station.layout.session_recording(session_id, sensor)),
            opened_at=now,
            calibration_id=calibration_in_force(session, sensor),
            recovered=False,
        )
        session.add(recording)
        return recording

    def _close(
        self, session_id: str, wanted: SessionState, reason: str | None = None
    ) -> SessionView:
        view = self.view(session_id)
        expected = self._expected(view.row)
        accounts = close_all(self._station, view.recordings, expected)
        with self._station.store.change() as session:
            row = the(session, CalibrationSession, session_id)
            row.finished_at = self._station.now()
            row.reason = reason
            for recording in recordings_of(session, row):
                recording.closed_at = row.finished_at
                note(recording, accounts[recording.id], expected[recording.sensor])
            _step(row, wanted)
            return _view(session, row)

    def _expected(self, row: CalibrationSession) -> dict[str, int | None]:
        """Return how many frames were commanded; the capture process counts those of sequences."""
        sensor = self._station.settings.sensor(row.sensor)
        in_sequences = sensor is not None and bool(sensor.calibration_exposures)
        return {row.sensor: None if in_sequences else row.pictures}

    def _still_open(self, row: CalibrationSession) -> bool:
        capture = self._station.captures.get(row.sensor)
        try:
            return capture is not None and capture.status().session_id == row.id
        except StationError:
            return False


def _view(session: Session, row: CalibrationSession) -> SessionView:
    return SessionView(row, recordings_of(session, row))


def _step(row: CalibrationSession, wanted: SessionState) -> None:
    SESSION.check(row.id, row.state, wanted)
    row.state = wanted


def _ensure_same(present: CalibrationSession, sensor: str, target: Target) -> CalibrationSession:
    if (present.sensor, present.target) != (sensor, str(target)):
        raise StateConflict(
            f"calibration session {present.id} is of sensor {present.sensor} and target "
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
