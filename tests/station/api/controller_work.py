"""Does what the worker does with a controller's jobs, but its mathematics."""

from station.store import (
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    end,
    recordings_of,
    start,
    the,
)


def begin(served, job_id):
    """Take up a job that is queued."""
    with served.store.change() as session:
        row = the(session, Job, job_id)
        start(row, at=served.station.now())
        if row.kind == JobKind.RECALIBRATE:
            the(session, Recalibration, row.subject).state = RecalibrationState.RUNNING


def work(served, job_id, *, well):
    """Bring a job to its end."""
    now = served.station.now()
    with served.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is JobState.QUEUED:
            start(job, at=now)
        end(job, JobState.DONE if well else JobState.FAILED, at=now)
        if job.kind == JobKind.MEASURE:
            row = the(session, Pass, job.subject)
            cut = any(each.recovered for each in recordings_of(session, row))
            ended = PassState.RECOVERED if cut else PassState.DONE
            row.state = ended if well else PassState.FAILED
        elif job.kind == JobKind.CALIBRATE:
            calibration = the(session, Calibration, job.subject)
            calibration.state = CalibrationState.READY if well else CalibrationState.FAILED
            calibration.document = "{}" if well else None
        else:
            recalibration = the(session, Recalibration, job.subject)
            recalibration.state = RecalibrationState.KEPT if well else RecalibrationState.FAILED
            recalibration.version += 1
