"""Having a rig calibrated, taking in one that was calibrated elsewhere, bringing one into force."""

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from calib import Target
from station.documents import RigDocument
from station.errors import InputUnusable, NotFound, StateConflict
from station.operations.arming import calibration_in_force
from station.operations.calibrations import closed_recording
from station.operations.collaborators import Station
from station.operations.sensors import rig_at, rig_given
from station.settings import RigSettings
from station.store import (
    Action,
    Actor,
    CalibrationSession,
    CalibrationState,
    Job,
    JobKind,
    JsonObject,
    RigActivation,
    RigCalibration,
    RigCalibrationPoints,
    SessionState,
    activate_rig,
    active_rig,
    add_job,
    audit,
    recordings_of,
    the,
)

_NO_TARGETS: Mapping[str, str] = {}


@dataclass(frozen=True, slots=True)
class RigCalibrationOrder:
    """Which rig to calibrate, and from what.

    Attributes
    ----------
    rig
        Of the settings.
    session
        A calibration session of the rig; or
    recordings
        one of each sensor.
    target, targets
        The board, and those of single sensors; the session's where not given.
    same_board
        Whether it is one board that all sensors see, not one each.
    board_sigma_mm
        How far each dot is from its place on the board.
    """

    rig: str
    session: str | None
    recordings: Mapping[str, str]
    target: Target | None
    targets: Mapping[str, Target]
    same_board: bool
    board_sigma_mm: float


def order_rig_calibration(
    station: Station, order: RigCalibrationOrder, *, by: Actor
) -> tuple[RigCalibration, Job]:
    """Put the calibration of a rig into the worker's list.

    It rests on the calibrations that are in force on its sensors now.

    Raises
    ------
    InputUnusable
        If rig, recordings and targets do not fit together.
    NotFound
        If the station knows no such session or recording.
    StateConflict
        If the session or a recording is not closed yet, or a sensor has no calibration in force.
    """
    rig = rig_given(station.settings, order.rig)
    calibration_id, job_id = station.new_id(), station.new_id()
    with station.store.change() as session:
        known = session.get(RigCalibration, calibration_id)
        if known is not None:  # ordered by this call, before the API process died of it
            return known, the(session, Job, known.job_id or "")
        ordered = _resolve(session, order, rig)
        job = add_job(session, job_id, JobKind.CALIBRATE_RIG, calibration_id, at=station.now())
        calibration = RigCalibration(
            id=calibration_id,
            state=CalibrationState.SOLVING,
            rig=rig.id,
            ordered=ordered,
            created_at=station.now(),
            job_id=job_id,
        )
        session.add(calibration)
        _note(station, session, Action.ORDER, calibration, by)
    station.jobs.submit(JobKind.CALIBRATE_RIG, job_id)
    return calibration, job


def _resolve(session: Session, order: RigCalibrationOrder, rig: RigSettings) -> JsonObject:
    if (order.session is None) == (not order.recordings):
        raise InputUnusable("give either a session or recordings to calibrate from, not both")
    recordings, targets = order.recordings, _NO_TARGETS
    if order.session is not None:
        recordings, targets = _of_session(session, order.session, rig)
    missing = [name for name in rig.sensors if name not in recordings]
    strange = [name for name in recordings if name not in rig.sensors]
    if missing or strange:
        raise InputUnusable(
            f"recordings are of {', '.join(recordings)}; allowed: one of each sensor of "
            f"rig {rig.id}, {', '.join(rig.sensors)}"
        )
    return {
        "recordings": {
            name: [closed_recording(session, recording, name)]
            for name, recording in recordings.items()
        },
        "calibrations": {name: _in_force(session, name) for name in rig.sensors},
        "targets": {name: _target_of(name, order, targets) for name in rig.sensors},
        "same_board": order.same_board,
        "board_sigma_mm": order.board_sigma_mm,
    }


def _of_session(
    session: Session, session_id: str, rig: RigSettings
) -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Return the recordings and boards of a session, by sensor."""
    row = the(session, CalibrationSession, session_id)
    if row.rig != rig.id:
        of = f"rig {row.rig}" if row.rig is not None else f"sensor {row.sensor}"
        raise InputUnusable(
            f"calibration session {row.id} is of {of}; give one of rig {rig.id}, or recordings"
        )
    if row.state is not SessionState.RECORDED:
        raise StateConflict(
            f"calibration session {row.id} is {row.state}; finish it, then calibrate from it",
            state=row.state,
        )
    recordings = {each.sensor: each.id for each in recordings_of(session, row)}
    boards = row.targets or {}
    return recordings, {name: boards.get(name, row.target) for name in rig.sensors}


def _target_of(sensor: str, order: RigCalibrationOrder, of_session: Mapping[str, str]) -> str:
    given = order.targets.get(sensor, order.target)
    if given is not None:
        return str(given)
    if sensor not in of_session:
        raise InputUnusable("recordings do not say which target they show; give a target")
    return of_session[sensor]


def _in_force(session: Session, sensor: str) -> str:
    found = calibration_in_force(session, sensor)
    if found is None:
        raise StateConflict(
            f"sensor {sensor} has no active calibration; calibrate it first, the rig rests on it",
            state="uncalibrated",
        )
    return found


def keep_rig_calibration(station: Station, document: RigDocument, *, by: Actor) -> RigCalibration:
    """Take in a rig that was calibrated elsewhere.

    Raises
    ------
    InputUnusable
        If it is of no rig of the station, or its sensors are not the rig's.
    """
    rig = rig_given(station.settings, document.rig)
    if set(document.names) != set(rig.sensors):
        raise InputUnusable(
            f"the file's rig {document.rig} has sensors {', '.join(document.names)}; "
            f"the station's has {', '.join(rig.sensors)}"
        )
    calibration = RigCalibration(
        id=station.new_id(),
        state=CalibrationState.READY,
        rig=rig.id,
        created_at=station.now(),
        document=document.model_dump_json(),
        passed=document.passed,
    )
    with station.store.change() as session:
        known = session.get(RigCalibration, calibration.id)
        if known is not None:  # taken in by this call, before the API process died of it
            return known
        session.add(calibration)
        _note(station, session, Action.ADD, calibration, by)
    return calibration


def _note(
    station: Station, session: Session, action: Action, calibration: RigCalibration, by: Actor
) -> None:
    after = {"rig": calibration.rig, "job": calibration.job_id}
    now = station.now()
    audit(session, action, "rig calibration", calibration.id, by=by, at=now, after=after)


def rig_calibration_points(station: Station, calibration_id: str, sensor: str) -> str:
    """Return the points of one sensor's pictures in a rig's calibration as CSV.

    Raises
    ------
    NotFound
        If there is no such calibration, or it has kept no points of such a sensor.
    """
    with station.store.look() as session:
        the(session, RigCalibration, calibration_id)
        points = session.get(RigCalibrationPoints, (calibration_id, sensor))
    if points is None:
        raise NotFound(
            f"rig calibration {calibration_id} has no points of a sensor {sensor}: it is not "
            "ready, was made elsewhere or by an earlier version, or the rig has no such sensor"
        )
    return points.csv


def active_rig_calibration(station: Station, rig: str) -> RigActivation:
    """Return what is in force on a rig.

    Raises
    ------
    NotFound
        If the station has no such rig, or nothing is in force on it.
    """
    rig_at(station.settings, rig)
    with station.store.look() as session:
        activation = active_rig(session, rig)
    if activation is None:
        raise NotFound(f"rig {rig} has no active calibration yet; put one")
    return activation


def activate_rig_calibration(
    station: Station, rig: str, calibration_id: str, *, seen: int | None, by: Actor
) -> RigActivation:
    """Bring a rig's calibration into force; `seen` is the version the caller read.

    Raises
    ------
    NotFound
        If the station has no such rig or calibration.
    InputUnusable, StateConflict
        If the calibration is of another rig, cannot measure wheels, or is not ready.
    VersionMissing, VersionConflict
        If the caller has not seen what is in force now.
    """
    rig_at(station.settings, rig)
    with station.store.change() as session:
        calibration = the(session, RigCalibration, calibration_id)
        if calibration.document is not None:
            RigDocument.model_validate_json(calibration.document).survey_of_wheels()
        return activate_rig(session, calibration, rig=rig, seen=seen, by=by, at=station.now())
