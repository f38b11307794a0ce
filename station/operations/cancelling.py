"""Ending a job before it is done: what it worked on stays usable."""

from station.operations.collaborators import Station
from station.store import (
    CALIBRATION,
    JOB,
    PASS,
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Pass,
    PassState,
    end,
    the,
)


def cancel_job(station: Station, job_id: str) -> Job:
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
        end(job, JobState.CANCELLED, at=station.now())
        if job.kind == JobKind.MEASURE:
            row = the(session, Pass, job.subject)
            PASS.check(row.id, row.state, PassState.RECORDED)
            row.state, row.reason = PassState.RECORDED, "its measuring was cancelled"
        else:
            calibration = the(session, Calibration, job.subject)
            CALIBRATION.check(calibration.id, calibration.state, CalibrationState.FAILED)
            calibration.state, calibration.reason = CalibrationState.FAILED, "cancelled"
    station.jobs.cancel(job_id)
    return job
