"""Pictures for a calibration, taken one by one while somebody moves the target."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock

from sqlalchemy.orm import Session

from calib import Target
from station.capture import Trigger
from station.errors import InputUnusable, StateConflict, StationError
from station.operations.arming import (
    arm,
    calibration_in_force,
    ensure_sensors_free,
    ensure_space_for_session,
)
from station.operations.closing import close_all, note
from station.operations.collaborators import Station
from station.operations.sensors import rig_given, sensor_given
from station.settings import SensorSettings
from station.store import (
    SESSION,
    Action,
    Actor,
    CalibrationSession,
    Recording,
    SessionState,
    audit,
    open_sessions,
    recordings_of,
    the,
)


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

    def open(self, session_id: str, order: SessionOrder, *, by: Actor) -> tuple[SessionView, bool]:
        """Ready a sensor, or all of a rig, for pictures; return the session and whether it is new.

        Raises
        ------
        InputUnusable
            If the station has no such sensor or rig, or a board is of none of its sensors.
        StateConflict
            If another recording runs, or the id is of another session.
        DiskFull
            If its pictures would not fit on the disk; the id stays free.
        CameraError, RecordingError
            If the sensor cannot record; the session has then failed.
        """
        sensors = self._sensors_of(order)
        with self._station.store.change() as session:
            present = session.get(CalibrationSession, session_id)
            if present is not None:
                return _view(session, _ensure_same(present, order)), False
            ensure_sensors_free(session, sensors, f"calibration session {session_id}")
            ensure_space_for_session(self._station, sensors)
            recordings = self._add(session, session_id, order, sensors)
            self._note(session, Action.ARM, session_id, by)
        try:
            for recording in recordings:
                arm(self._station, recording, owner=session_id, trigger=Trigger.SOFTWARE)
        except StationError as error:
            self._close(session_id, SessionState.FAILED, f"not armed: {error}")
            raise
        with self._station.store.change() as session:
            row = the(session, CalibrationSession, session_id)
            _step(row, SessionState.OPEN)
            return _view(session, row), True

    def take_picture(self, session_id: str) -> SessionView:
        """Take one picture with each sensor and return when they are recorded.

        Those of a rig come one after the other, as no laser is to shine into another's picture.

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
            view = self.view(session_id)
            row = view.row
            if row.state is not SessionState.OPEN:
                raise StateConflict(
                    f"calibration session {session_id} is {row.state}; "
                    "pictures are taken while it is open",
                    state=row.state,
                )
            for recording in view.recordings:
                self._station.captures[recording.sensor].trigger()
            with self._station.store.change() as session:
                row = the(session, CalibrationSession, session_id)
                row.pictures += 1
                return _view(session, row)

    def finish(self, session_id: str, *, by: Actor) -> SessionView:
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
            with self._station.store.change() as session:
                self._note(session, Action.FINISH, session_id, by)
            return self._close(session_id, SessionState.RECORDED)

    def take_up(self) -> None:
        """Close, after a start, the sessions that no capture process still holds open."""
        with self._station.store.look() as session:
            views = [_view(session, row) for row in open_sessions(session)]
        for view in views:
            if not self._still_open(view):
                with self._camera:
                    self._close(view.row.id, SessionState.RECORDED, "the station stopped meanwhile")

    def _sensors_of(self, order: SessionOrder) -> list[SensorSettings]:
        settings = self._station.settings
        if (order.sensor is None) == (order.rig is None):
            raise InputUnusable("give either a sensor or a rig to take pictures with, not both")
        if order.sensor is not None:
            names: tuple[str, ...] = (order.sensor,)
        else:
            names = rig_given(settings, order.rig or "").sensors
        strange = [name for name in order.targets or {} if name not in names]
        if strange:
            raise InputUnusable(f"a target of sensor {strange[0]}; allowed: {', '.join(names)}")
        return [sensor_given(settings, name) for name in names]

    def _add(
        self,
        session: Session,
        session_id: str,
        order: SessionOrder,
        sensors: Sequence[SensorSettings],
    ) -> list[Recording]:
        now = self._station.now()
        session.add(
            CalibrationSession(
                id=session_id,
                state=SessionState.ARMED,
                sensor=order.sensor,
                rig=order.rig,
                target=str(order.target),
                targets=order.targets_kept,
                pictures=0,
                opened_at=now,
            )
        )
        session.flush()
        recordings = [
            Recording(
                id=f"session.{session_id}.{sensor.id}",
                sensor=sensor.id,
                session_id=session_id,
                path=str(self._station.layout.session_recording(session_id, sensor.id)),
                opened_at=now,
                calibration_id=calibration_in_force(session, sensor.id),
                recovered=False,
            )
            for sensor in sensors
        ]
        session.add_all(recordings)
        return recordings

    def _close(
        self, session_id: str, wanted: SessionState, reason: str | None = None
    ) -> SessionView:
        view = self.view(session_id)
        expected = self._expected(view)
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

    def _note(self, session: Session, action: Action, session_id: str, by: Actor) -> None:
        now = self._station.now()
        audit(session, action, "calibration session", session_id, by=by, at=now)

    def _expected(self, view: SessionView) -> dict[str, int | None]:
        """Return how many frames were commanded; the capture process counts those of sequences."""
        sensors = [recording.sensor for recording in view.recordings]
        return {
            sensor: None if self._takes_sequences(sensor) else view.row.pictures
            for sensor in sensors
        }

    def _takes_sequences(self, sensor_id: str) -> bool:
        sensor = self._station.settings.sensor(sensor_id)
        return sensor is not None and bool(sensor.calibration_exposures)

    def _still_open(self, view: SessionView) -> bool:
        try:
            return all(
                self._station.captures[recording.sensor].status().session_id == view.row.id
                for recording in view.recordings
            )
        except (KeyError, StationError):
            return False


def _view(session: Session, row: CalibrationSession) -> SessionView:
    return SessionView(row, recordings_of(session, row))


def _step(row: CalibrationSession, wanted: SessionState) -> None:
    SESSION.check(row.id, row.state, wanted)
    row.state = wanted


def _ensure_same(present: CalibrationSession, order: SessionOrder) -> CalibrationSession:
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
