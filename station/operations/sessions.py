"""Pictures for a calibration, taken one by one while somebody moves the target."""

from collections.abc import Sequence
from threading import Lock

from sqlalchemy.orm import Session

from station.capture import Trigger
from station.errors import InputUnusable, StateConflict, StationError
from station.operations.arming import (
    arm,
    calibration_in_force,
    ensure_sensors_free,
    ensure_space_for_session,
)
from station.operations.collaborators import Station
from station.operations.picture_taking import begin_picture, begun_before
from station.operations.sensors import rig_given, sensor_given
from station.operations.session_ends import close_session, end_session, note_session_end
from station.operations.session_orders import (
    SessionOrder,
    SessionView,
    ensure_same_order,
    session_view,
)
from station.settings import SensorSettings
from station.store import (
    SESSION,
    Action,
    Actor,
    CalibrationSession,
    EndedBy,
    Recording,
    SessionState,
    audit,
    open_sessions,
    the,
)


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
            return session_view(session, the(session, CalibrationSession, session_id))

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
                return session_view(session, ensure_same_order(present, order)), False
            ensure_sensors_free(session, sensors, f"calibration session {session_id}")
            ensure_space_for_session(self._station, sensors)
            recordings = self._add(session, session_id, order, sensors)
            now = self._station.now()
            audit(session, Action.ARM, "calibration session", session_id, by=by, at=now)
        try:
            for recording in recordings:
                arm(self._station, recording, owner=session_id, trigger=Trigger.SOFTWARE)
        except StationError as error:
            close_session(self._station, session_id, f"not armed: {error}")
            raise
        return self._ensure_open(session_id), True

    def take_picture(self, session_id: str, *, name: str, by: Actor) -> SessionView:
        """Take one picture with each sensor and return when they are recorded.

        Those of a rig come one after the other, as no laser is to shine into another's picture.

        Parameters
        ----------
        name
            The picture's: the last one's name once more takes only what is missing of it.

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
            with self._station.store.look() as session:
                begun = begun_before(session, session_id, name)
            if begun is not None and begun.counted(row):
                return view
            if row.state is not SessionState.OPEN:
                raise StateConflict(
                    f"calibration session {session_id} is {row.state}; "
                    "pictures are taken while it is open",
                    state=row.state,
                )
            if begun is None:
                begun = begin_picture(self._station, name, row, view.recordings, by)
            for sensor in begun.missing(self._station, view.recordings):
                self._station.captures[sensor].trigger()
            with self._station.store.change() as session:
                row = the(session, CalibrationSession, session_id)
                row.pictures += 1
                return session_view(session, row)

    def finish(self, session_id: str, *, by: Actor) -> SessionView:
        """Close the recording of a session; one that has ended, also by itself, stays as it is.

        Raises
        ------
        NotFound
            If there is no such session.
        StateConflict
            If it is not yet armed, or could not be armed.
        """
        with self._camera:
            row = self.view(session_id).row
            never_began = row.state is SessionState.FAILED and row.ended_by is None
            if row.state is SessionState.ARMED or never_began:
                raise StateConflict(
                    f"calibration session {session_id} is {row.state}; finish one that is open",
                    state=row.state,
                )
            note_session_end(self._station, session_id, EndedBy.CONTROLLER, by=by)
            return end_session(self._station, session_id)

    def end_overdue(self, session_id: str, why: str) -> bool:
        """End a session that nobody goes on with; False where somebody else has ended it."""
        with self._camera:
            ends = note_session_end(self._station, session_id, EndedBy.TIMEOUT, why)
            end_session(self._station, session_id)
            return ends

    def take_up(self) -> None:
        """Close, after a start, the sessions that no capture process still holds open."""
        with self._station.store.look() as session:
            names = [row.id for row in open_sessions(session)]
        for session_id in names:
            self.bring_on(session_id)

    def bring_on(self, session_id: str) -> None:
        """Go on with a session at which a process or call stopped in the middle."""
        with self._camera:
            view = self.view(session_id)
            if view.row.state not in SESSION.unfinished:
                return
            if view.row.ended_by is None and self._still_open(view):
                self._ensure_open(session_id)
                return
            why = "the station stopped meanwhile"
            note_session_end(self._station, session_id, EndedBy.RESTART, why)
            end_session(self._station, session_id)

    def _ensure_open(self, session_id: str) -> SessionView:
        with self._station.store.change() as session:
            row = the(session, CalibrationSession, session_id)
            if row.state is not SessionState.OPEN:
                _step(row, SessionState.OPEN)
            return session_view(session, row)

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

    def _still_open(self, view: SessionView) -> bool:
        try:
            return all(
                self._station.captures[recording.sensor].status().session_id == view.row.id
                for recording in view.recordings
            )
        except (KeyError, StationError):
            return False


def _step(row: CalibrationSession, wanted: SessionState) -> None:
    SESSION.check(row.id, row.state, wanted)
    row.state = wanted
