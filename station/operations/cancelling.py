"""Ending a job before it is done: what it worked on stays usable."""

from sqlalchemy.orm import Session

from station.operations.collaborators import Station
from station.store import (
    CALIBRATION,
    JOB,
    PASS,
    RECALIBRATION,
    Action,
    Actor,
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    RigCalibration,
    audit,
    end,
    the,
)


def cancel_job(station: Station, job_id: str, *, by: Actor) -> Job:
    """Cancel a job; one that is cancelled already stays so.

    A pass goes back to what it was, recorded; a calibration has failed.

    Raises
    ------
    NotFound
        If there is no such job.
    StateConflict
        If it has ended otherwise.
    """
    with station.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is JobState.CANCELLED:
            return job
        JOB.check(job.id, job.state, JobState.CANCELLED)
        was = {"state": job.state.value}
        end(job, JobState.CANCELLED, at=station.now())
        audit(session, Action.CANCEL, "job", job.id, by=by, at=station.now(), before=was)
        if job.kind == JobKind.MEASURE:
            _give_recording_back(the(session, Pass, job.subject))
        elif job.kind == JobKind.RECALIBRATE:
            _fail_recalibration(session, job)
        elif job.kind in {JobKind.CALIBRATE, JobKind.CALIBRATE_RIG}:
            _fail_calibration(session, job)
    station.jobs.cancel(job_id)
    return job


def _give_recording_back(row: Pass) -> None:
    # Armed and recording lead to recorded too, but not by this: the sensors would go on.
    if row.state is PassState.MEASURING:
        PASS.check(row.id, row.state, PassState.RECORDED)
        row.state, row.reason = PassState.RECORDED, "its measuring was cancelled"


def _fail_recalibration(session: Session, job: Job) -> None:
    row = the(session, Recalibration, job.subject)
    RECALIBRATION.check(row.id, row.state, RecalibrationState.FAILED)
    row.state, row.reason, row.ended_at = RecalibrationState.FAILED, "cancelled", job.ended_at
    row.version += 1


def _fail_calibration(session: Session, job: Job) -> None:
    calibration: Calibration | RigCalibration
    if job.kind == JobKind.CALIBRATE_RIG:
        calibration = the(session, RigCalibration, job.subject)
    else:
        calibration = the(session, Calibration, job.subject)
    CALIBRATION.check(calibration.id, calibration.state, CalibrationState.FAILED)
    calibration.state, calibration.reason = CalibrationState.FAILED, "cancelled"
