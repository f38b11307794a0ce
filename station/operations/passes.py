"""A train goes by: arm, record, close, reconcile with the controller's count, have it measured."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock

from sqlalchemy.orm import Session

from station.capture import Trigger
from station.errors import StationError
from station.operations.arming import (
    arm,
    calibration_in_force,
    ensure_sensors_free,
    ensure_space_for_pass,
    rig_in_force,
)
from station.operations.closing import Closed, close_all, note
from station.operations.collaborators import Station
from station.operations.repeats import ensure_consist, ensure_same
from station.operations.sensors import sensor_given
from station.settings import SensorSettings
from station.store import (
    PASS,
    Action,
    Actor,
    AxleWheel,
    JobKind,
    Measurement,
    Pass,
    PassState,
    Recording,
    add_job,
    audit,
    places_of,
    recordings_of,
    the,
    unfinished_passes,
    wheels_of,
)
from station.trains import Consist, TrainPicture, keep_axles, train_picture


@dataclass(frozen=True, slots=True)
class PassView:
    """A pass and what its sensors recorded."""

    row: Pass
    recordings: Sequence[Recording]


@dataclass(frozen=True, slots=True)
class PassWheels:
    """The wheels of a pass, each one's place in the train by its id, and the train."""

    row: Pass
    wheels: Sequence[Measurement]
    places: Mapping[int, AxleWheel]
    train: TrainPicture


class Passes:
    """The desk for passes: each call may come twice, late, or after a crash."""

    def __init__(self, station: Station) -> None:
        self._station = station
        # Closing takes as long as the last frames: a second finish waits and gets the same answer.
        self._closing = Lock()

    def view(self, pass_id: str) -> PassView:
        """Return a pass.

        Raises
        ------
        NotFound
            If there is none of that id.
        """
        with self._station.store.look() as session:
            return _view(session, the(session, Pass, pass_id))

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
        """Arm every sensor for a train; return the pass and whether it is new.

        Raises
        ------
        StateConflict
            If another recording runs, this pass has failed, or its id names another train or
            consist.
        DiskFull
            If the longest pass would not fit on the disk; the id stays free.
        CameraError, RecordingError
            If a sensor cannot record; the pass has then failed.
        """
        with self._station.store.change() as session:
            known = session.get(Pass, pass_id)
            if known is not None:
                return _view(session, ensure_same(known, train, consist)), False
            ensure_sensors_free(session, self._station.sensors, f"pass {pass_id}")
            ensure_space_for_pass(self._station)
            view = self._add(session, pass_id, train, consist)
            told = {"train": train}
            now = self._station.now()
            audit(session, Action.ARM, "pass", pass_id, by=by, at=now, after=told)
        try:
            self._arm_all(view, pass_id)
        except StationError as error:
            self._fail(view, f"not armed: {error}")
            raise
        with self._station.store.change() as session:
            row = the(session, Pass, pass_id)
            _step(row, PassState.RECORDING)
            return _view(session, row), True

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
            If it is not yet armed, has failed, or has another consist.
        InputUnusable
            If a trigger count is of a sensor that the station has not.
        """
        for sensor_id in triggers:
            sensor_given(self._station.settings, sensor_id)
        expected = {sensor.id: triggers.get(sensor.id, axles) for sensor in self._station.sensors}
        with self._closing:
            view = self.view(pass_id)
            if view.row.state in {PassState.ARMED, PassState.FAILED}:
                PASS.check(pass_id, view.row.state, PassState.MEASURING)
            ensure_consist(view.row, consist)
            if view.row.state is not PassState.RECORDING:
                return view
            self._note_finish(pass_id, axles, consist, by)
            return self._close(view, expected)

    def take_up(self) -> None:
        """Go on, after a start, with passes that were open when the station stopped.

        A pass whose sensors all still record it is left to the controller's finish; another is
        closed with what was saved.
        """
        with self._station.store.look() as session:
            views = [
                _view(session, row)
                for row in unfinished_passes(session)
                if row.state in {PassState.ARMED, PassState.RECORDING}
            ]
        for view in views:
            if all(self._still_records(recording, view.row.id) for recording in view.recordings):
                self._step(view.row.id, PassState.RECORDING)
            else:
                with self._closing:
                    self._close(view, {})

    def _note_finish(
        self, pass_id: str, axles: int | None, consist: Consist | None, by: Actor
    ) -> None:
        with self._station.store.change() as session:
            row = the(session, Pass, pass_id)
            row.axles = axles
            if row.consist is None and consist is not None:
                row.consist = consist.to_json()
            told = {"axles": axles}
            now = self._station.now()
            audit(session, Action.FINISH, "pass", pass_id, by=by, at=now, after=told)

    def _add(
        self, session: Session, pass_id: str, train: str | None, consist: Consist | None
    ) -> PassView:
        now = self._station.now()
        row = Pass(
            id=pass_id,
            state=PassState.ARMED,
            train=train,
            opened_at=now,
            consist=None if consist is None else consist.to_json(),
        )
        session.add(row)
        recordings = [
            Recording(
                # With "pass." before it, as a calibration session may bear the same name.
                id=f"pass.{pass_id}.{sensor.id}",
                sensor=sensor.id,
                pass_id=pass_id,
                path=str(self._station.layout.pass_recording(pass_id, sensor.id)),
                opened_at=now,
                calibration_id=calibration_in_force(session, sensor.id),
                rig_calibration_id=rig_in_force(session, self._station.settings, sensor.id),
                recovered=False,
            )
            for sensor in self._station.sensors
        ]
        session.add_all(recordings)
        return PassView(row, recordings)

    def _arm_all(self, view: PassView, pass_id: str) -> None:
        def arm_one(pair: tuple[Recording, SensorSettings]) -> None:
            recording, sensor = pair
            arm(self._station, recording, owner=pass_id, trigger=Trigger(sensor.trigger))

        pairs = list(zip(view.recordings, self._station.sensors, strict=True))
        with ThreadPoolExecutor(max_workers=len(pairs)) as pool:
            list(pool.map(arm_one, pairs))

    def _fail(self, view: PassView, reason: str) -> None:
        accounts = close_all(self._station, view.recordings, {})
        with self._station.store.change() as session:
            row = the(session, Pass, view.row.id)
            self._note_accounts(session, row, accounts, {})
            _step(row, PassState.FAILED)
            row.reason = reason

    def _close(self, view: PassView, expected: Mapping[str, int | None]) -> PassView:
        accounts = close_all(self._station, view.recordings, expected)
        with self._station.store.change() as session:
            row = the(session, Pass, view.row.id)
            self._note_accounts(session, row, accounts, expected)
            _step(row, PassState.RECORDED)
            self._decide_next(session, row)
            closed = _view(session, row)
        if row.job_id is not None:
            self._station.jobs.submit(JobKind.MEASURE, row.job_id)
        return closed

    def _note_accounts(
        self,
        session: Session,
        row: Pass,
        accounts: Mapping[str, Closed],
        expected: Mapping[str, int | None],
    ) -> None:
        row.finished_at = self._station.now()
        for recording in recordings_of(session, row):
            recording.closed_at = row.finished_at
            note(recording, accounts[recording.id], expected.get(recording.sensor))

    def _decide_next(self, session: Session, row: Pass) -> None:
        recordings = recordings_of(session, row)
        filled = [recording for recording in recordings if recording.recorded]
        if not filled and all(recording.expected == 0 for recording in recordings):
            _step(row, PassState.DONE)
            row.reason = "no wheel went by"
        elif not filled:
            _step(row, PassState.FAILED)
            row.reason = "no frame was recorded: " + "; ".join(
                f"{recording.sensor}: {recording.summary}" for recording in recordings
            )
        elif all(recording.calibration_id is None for recording in filled):
            row.reason = "not measured: no sensor had an active calibration when it was recorded"
        else:
            self._have_measured(session, row)
            return
        # Nothing more will be measured of it; what the controller counted are rows all the same.
        keep_axles(session, row, self._station.settings)

    def _have_measured(self, session: Session, row: Pass) -> None:
        job = add_job(
            session, self._station.new_id(), JobKind.MEASURE, row.id, at=self._station.now()
        )
        _step(row, PassState.MEASURING)
        row.job_id = job.id

    def _still_records(self, recording: Recording, pass_id: str) -> bool:
        capture = self._station.captures.get(recording.sensor)
        try:
            return capture is not None and capture.status().session_id == pass_id
        except StationError:
            return False

    def _step(self, pass_id: str, wanted: PassState) -> None:
        with self._station.store.change() as session:
            row = the(session, Pass, pass_id)
            if row.state is not wanted:
                _step(row, wanted)


def _view(session: Session, row: Pass) -> PassView:
    return PassView(row, recordings_of(session, row))


def _step(row: Pass, wanted: PassState) -> None:
    PASS.check(row.id, row.state, wanted)
    row.state = wanted
