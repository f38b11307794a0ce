"""A train goes by: arm, record, close, reconcile with the controller's count, have it measured."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from threading import Lock

from sqlalchemy.orm import Session

from station.capture import CaptureStatus, Trigger
from station.errors import StationError
from station.operations.arming import (
    arm,
    ensure_sensors_free,
    ensure_space_for_pass,
)
from station.operations.beginning import begin_pass, clear_empty, may_begin_again
from station.operations.collaborators import Station
from station.operations.counts import Counted, take_counts
from station.operations.ending import end_pass, fail_pass, note_own_end, step
from station.operations.rejoining import Rejoining
from station.operations.repeats import ensure_same
from station.operations.sensors import sensor_given
from station.operations.views import PassView, PassWheels, view_of
from station.processes.threads import at_a_time
from station.store import (
    HELD,
    PASS,
    Action,
    Actor,
    EndedBy,
    Pass,
    PassState,
    Recording,
    audit,
    passes_held,
    the,
)
from station.store.measured import places_of, wheels_of
from station.trains import Consist, keep_axles, train_picture


class Passes:
    """The desk for passes: each call may come twice, late, or after a crash."""

    def __init__(self, station: Station) -> None:
        self._station = station
        # Closing takes as long as the last frames: a second finish waits and gets the same answer,
        # and a time-out that falls together with it finds the pass ended.
        self._closing = Lock()
        self._rejoining = Rejoining(station)
        self._arming: set[str] = set()
        """Passes that a call is arming the sensors for."""

    def view(self, pass_id: str) -> PassView:
        """Return a pass.

        Raises
        ------
        NotFound
            If there is none of that id.
        """
        with self._station.store.look() as session:
            return view_of(session, pass_id)

    def wheels(self, pass_id: str) -> PassWheels:
        """Return the wheels of a pass, as measured with the calibrations it was recorded under.

        Raises
        ------
        NotFound
            If there is none of that id.
        """
        with self._station.store.look() as session:
            row = the(session, Pass, pass_id)
            wheels = wheels_of(session, row)
            return PassWheels(
                row, wheels, places_of(session, wheels), train_picture(session, row, wheels)
            )

    def open(
        self, pass_id: str, *, train: str | None, by: Actor, consist: Consist | None = None
    ) -> tuple[PassView, bool]:
        """Arm every sensor for a train; return the pass and whether that was done now.

        One that failed as a sensor did not arm, and of which nothing is recorded, begins again.

        Raises
        ------
        StateConflict
            If another recording runs, this pass has failed later, or its id names another train
            or consist.
        DiskFull
            If the longest pass would not fit on the disk; the id stays free.
        CameraError, RecordingError
            If a sensor cannot record; the pass has then failed.
        """
        with self._station.store.look() as session:
            # A call that comes again does not wait for its turn to write.
            opened = _opened(session, pass_id, train, consist)
            if opened is not None:
                return opened, False
        with self._station.store.change() as session:
            opened = _opened(session, pass_id, train, consist)
            if opened is not None:
                return opened, False
            ensure_sensors_free(session, self._station.sensors, f"pass {pass_id}")
            ensure_space_for_pass(self._station)
            again = session.get(Pass, pass_id) is not None
            view = begin_pass(self._station, session, pass_id, train, consist)
            told = {"train": train}
            now = self._station.now()
            audit(session, Action.ARM, "pass", pass_id, by=by, at=now, after=told)
            self._arming.add(pass_id)  # before anybody else can see the row
        try:
            return self._record(view, view.recordings, again=again), True
        finally:
            self._arming.discard(pass_id)

    def finish(
        self,
        pass_id: str,
        *,
        axles: int | None,
        triggers: Mapping[str, int],
        by: Actor,
        consist: Consist | None = None,
    ) -> PassView:
        """Close the recordings of a pass, hold them against the count, and have them measured.

        Of a pass that has ended already, by an earlier call or by itself, it brings in what was
        counted and named, where nobody had told that yet.

        Parameters
        ----------
        axles
            Wheels that went by every sensor; None where nobody counted.
        triggers
            Triggers given to single sensors, where they differ from `axles`.
        consist
            The train's wheelsets, where they were not named when it came.

        Raises
        ------
        NotFound
            If there is no such pass.
        StateConflict
            If it is not yet armed, could not be armed, or something else was counted or named.
        InputUnusable
            If a trigger count is of a sensor that the station has not.
        """
        for sensor_id in triggers:
            sensor_given(self._station.settings, sensor_id)
        with self._closing:
            view = self._tell(pass_id, Counted(axles, triggers, consist), by)
            return end_pass(self._station, pass_id) if view.row.state in HELD else view

    def end_overdue(self, pass_id: str, why: str) -> bool:
        """End a pass whose controller is lost; False where somebody else has ended it."""
        with self._closing:
            ends = note_own_end(self._station, pass_id, EndedBy.TIMEOUT, why)
            if ends:
                end_pass(self._station, pass_id)
            return ends

    def rejoin(self, pass_id: str, statuses: Mapping[str, CaptureStatus | None]) -> None:
        """Have sensors that stand idle beside a pass which goes on record the rest of it."""
        with self._closing:
            view = self.view(pass_id)
            if view.row.state is PassState.RECORDING and view.row.ended_by is None:
                self._rejoining.rejoin(view.recordings, statuses)

    def take_up(self) -> None:
        """Go on, after a start, with the passes that were open when the station stopped."""
        with self._station.store.look() as session:
            names = [row.id for row in passes_held(session)]
        for pass_id in names:
            self.bring_on(pass_id)

    def bring_on(self, pass_id: str) -> None:
        """Go on with a pass at which a process or call stopped in the middle.

        One whose end is written down is closed.  One that a sensor still records is left to the
        controller's finish, the other sensors being armed where that had not been done; one that no
        sensor records has ended, with what was saved.
        """
        with self._closing:
            view = self.view(pass_id)
            row, recordings = view.row, view.recordings
            if row.state not in HELD or pass_id in self._arming:
                return
            if row.ended_by is not None:
                end_pass(self._station, pass_id)
                return
            silent = [each for each in recordings if not self._still_records(each)]
            if len(silent) == len(recordings):
                why = "no sensor recorded it any more when the station took it up again"
                note_own_end(self._station, pass_id, EndedBy.RESTART, why)
                end_pass(self._station, pass_id)
            elif row.state is PassState.ARMED:
                with suppress(StationError):  # the pass has failed, and says so
                    self._record(view, silent)

    def _record(
        self, view: PassView, unarmed: Sequence[Recording], *, again: bool = False
    ) -> PassView:
        """Arm the sensors of recordings, and say that the pass is recorded."""
        try:
            at_a_time(self._arm_again if again else self._arm, unarmed)
        except StationError as error:
            fail_pass(self._station, view, f"not armed: {error}")
            raise
        with self._station.store.change() as session:
            step(the(session, Pass, view.row.id), PassState.RECORDING)
            return view_of(session, view.row.id)

    def _arm(self, recording: Recording) -> None:
        sensor = sensor_given(self._station.settings, recording.sensor)
        owner = recording.pass_id or ""
        arm(self._station, recording, owner=owner, trigger=Trigger(sensor.trigger))

    def _arm_again(self, recording: Recording) -> None:
        clear_empty(self._station, recording)
        self._arm(recording)

    def _tell(self, pass_id: str, told: Counted, by: Actor) -> PassView:
        """Write down what a finish tells, and that it ends a pass that had not ended."""
        with self._station.store.change() as session:
            view = view_of(session, pass_id)
            row = view.row
            never_began = row.state is PassState.FAILED and row.ended_by is None
            if row.state is PassState.ARMED or never_began:
                PASS.check(pass_id, row.state, PassState.MEASURING)
            news = take_counts(row, view.recordings, told)
            if row.state is PassState.RECORDING and row.ended_by is None:
                row.ended_by = EndedBy.CONTROLLER
            elif not news:
                return view
            now = self._station.now()
            after = {"axles": told.axles}
            audit(session, Action.FINISH, "pass", pass_id, by=by, at=now, after=after)
            if row.state not in {PassState.RECORDING, PassState.MEASURING}:
                # The job of a pass that is being measured does this when it ends.
                keep_axles(session, row, self._station.settings)
            return view

    def _still_records(self, recording: Recording) -> bool:
        capture = self._station.captures.get(recording.sensor)
        try:
            return capture is not None and capture.status().session_id == recording.pass_id
        except StationError:
            return False


def _opened(
    session: Session, pass_id: str, train: str | None, consist: Consist | None
) -> PassView | None:
    """Return the pass that an earlier call opened; None where there is none, or it begins again."""
    if session.get(Pass, pass_id) is None:
        return None
    view = view_of(session, pass_id)
    again = may_begin_again(view)
    ensure_same(view.row, train, consist, again=again)
    return None if again else view
