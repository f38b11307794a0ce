"""Having a calibration solved, and bringing one into force."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from sqlalchemy.orm import Session

from calib import Target
from station.errors import InputUnusable, NotFound, StateConflict
from station.operations.collaborators import Station
from station.operations.sensors import sensor_at, sensor_given
from station.store import (
    Action,
    Activation,
    Actor,
    Calibration,
    CalibrationPoints,
    CalibrationSession,
    CalibrationState,
    Job,
    JobKind,
    Recording,
    SessionState,
    activate,
    active,
    add_job,
    audit,
    recordings_of,
    the,
)

MethodName = Literal["joint", "deviation", "preplanar"]


@dataclass(frozen=True, slots=True)
class CalibrationOrder:
    """What to calibrate, from what, and how."""

    sensor: str
    method: MethodName
    session: str | None
    recordings: Sequence[str]
    target: Target | None
    laser_off: Sequence[str]


def order_calibration(
    station: Station, order: CalibrationOrder, *, by: Actor
) -> tuple[Calibration, Job]:
    """Put a calibration into the worker's list.

    Raises
    ------
    InputUnusable
        If sensor, recordings and target do not fit together.
    NotFound
        If the station knows no such session or recording.
    StateConflict
        If the session or a recording is not closed yet.
    """
    sensor_given(station.settings, order.sensor)
    calibration_id, job_id = station.new_id(), station.new_id()
    with station.store.change() as session:
        known = session.get(Calibration, calibration_id)
        if known is not None:  # ordered by this call, before the API process died of it
            return known, the(session, Job, known.job_id)
        recordings, target = _resolve(session, order)
        laser_off = [
            closed_recording(session, recording, order.sensor) for recording in order.laser_off
        ]
        job = add_job(session, job_id, JobKind.CALIBRATE, calibration_id, at=station.now())
        calibration = Calibration(
            id=calibration_id,
            state=CalibrationState.SOLVING,
            sensor=order.sensor,
            target=target,
            method=order.method,
            recording_ids={"recordings": recordings, "laser_off": laser_off},
            created_at=station.now(),
            job_id=job_id,
        )
        session.add(calibration)
        ordered = {"sensor": order.sensor, "job": job_id}
        audit(
            session,
            Action.ORDER,
            "calibration",
            calibration_id,
            by=by,
            at=station.now(),
            after=ordered,
        )
    station.jobs.submit(JobKind.CALIBRATE, job_id)
    return calibration, job


def _resolve(session: Session, order: CalibrationOrder) -> tuple[list[str], str]:
    if (order.session is None) == (not order.recordings):
        raise InputUnusable("give either a session or recordings to calibrate from, not both")
    if order.session is None:
        if order.target is None:
            raise InputUnusable("recordings do not say which target they show; give a target")
        closed = [
            closed_recording(session, recording, order.sensor) for recording in order.recordings
        ]
        return closed, str(order.target)
    row = the(session, CalibrationSession, order.session)
    if row.state is not SessionState.RECORDED:
        raise StateConflict(
            f"calibration session {row.id} is {row.state}; finish it, then calibrate from it",
            state=row.state,
        )
    # Of a rig's session the sensor's own.
    recordings = [
        each.id
        for each in recordings_of(session, row)
        if row.rig is None or each.sensor == order.sensor
    ]
    if not recordings:
        raise InputUnusable(
            f"calibration session {row.id} of rig {row.rig} has no sensor {order.sensor}"
        )
    closed = [closed_recording(session, recording, order.sensor) for recording in recordings]
    shown = (row.targets or {}).get(order.sensor, row.target)
    return closed, str(order.target or shown)


def closed_recording(session: Session, recording_id: str, sensor: str) -> str:
    """Return the id of a recording after checking that a sensor can be calibrated from it.

    Raises
    ------
    NotFound
        If the station knows no such recording.
    StateConflict
        If it still runs, or was deleted.
    InputUnusable
        If it is of another sensor.
    """
    recording = the(session, Recording, recording_id)
    if recording.closed_at is None:
        raise StateConflict(
            f"recording {recording.id} still runs; finish it, then calibrate from it",
            state="recording",
        )
    if recording.deleted_at is not None:
        raise StateConflict(
            f"recording {recording.id} was deleted on {recording.deleted_at:%Y-%m-%d} "
            f"({recording.deleted_why}); calibrate from one that is there",
            state="deleted",
        )
    if recording.sensor != sensor:
        raise InputUnusable(
            f"recording {recording.id} is of sensor {recording.sensor}, not of {sensor}; "
            "give recordings of the sensor to calibrate"
        )
    return recording.id


def calibration_points(station: Station, calibration_id: str) -> str:
    """Return the points of a calibration as CSV.

    Raises
    ------
    NotFound
        If there is no such calibration.
    StateConflict
        If it is not ready.
    """
    with station.store.look() as session:
        calibration = the(session, Calibration, calibration_id)
        points = session.get(CalibrationPoints, calibration_id)
    if points is None:
        raise StateConflict(
            f"calibration {calibration_id} is {calibration.state}; only a ready one has points",
            state=calibration.state,
        )
    return points.csv


def active_calibration(station: Station, sensor: str) -> Activation:
    """Return what is in force on a sensor.

    Raises
    ------
    NotFound
        If the station has no such sensor, or nothing is in force on it.
    """
    sensor_at(station.settings, sensor)
    with station.store.look() as session:
        activation = active(session, sensor)
    if activation is None:
        raise NotFound(f"sensor {sensor} has no active calibration yet; put one")
    return activation


def activate_calibration(
    station: Station, sensor: str, calibration_id: str, *, seen: int | None, by: Actor
) -> Activation:
    """Bring a calibration into force on a sensor; `seen` is the version the caller read.

    Raises
    ------
    NotFound
        If the station has no such sensor or calibration.
    InputUnusable, StateConflict
        If the calibration is of another sensor, or not ready.
    VersionMissing, VersionConflict
        If the caller has not seen what is in force now.
    """
    sensor_at(station.settings, sensor)
    with station.store.change() as session:
        calibration = the(session, Calibration, calibration_id)
        return activate(session, calibration, sensor=sensor, seen=seen, by=by, at=station.now())
