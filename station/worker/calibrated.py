"""How the job of a calibration, of a sensor or of a rig, ends: kept, or failed with the reason."""

from collections.abc import Iterable

from station.documents import CalibrationDocument, RigDocument
from station.store import (
    CALIBRATION,
    Calibration,
    CalibrationState,
    Job,
    JobState,
    RigCalibration,
    Table,
    end,
    the,
)
from station.worker.context import WorkContext

Kind = type[Calibration] | type[RigCalibration]


def keep(
    context: WorkContext,
    job_id: str,
    kind: Kind,
    document: CalibrationDocument | RigDocument,
    points: Iterable[Table],
) -> None:
    """End a job with what it solved, and the points of that; nothing where it was cancelled."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is not JobState.RUNNING:  # cancelled while the last step ran
            return
        calibration = the(session, kind, job.subject)
        CALIBRATION.check(calibration.id, calibration.state, CalibrationState.READY)
        calibration.state = CalibrationState.READY
        calibration.document = document.model_dump_json()
        calibration.passed = document.passed
        session.add_all(points)
        end(job, JobState.DONE, at=context.now())


def fail(context: WorkContext, job_id: str, kind: Kind, why: str) -> None:
    """End a job without a calibration, if it has not ended."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state not in {JobState.QUEUED, JobState.RUNNING}:
            return
        calibration = the(session, kind, job.subject)
        CALIBRATION.check(calibration.id, calibration.state, CalibrationState.FAILED)
        calibration.state, calibration.reason = CalibrationState.FAILED, why
        end(job, JobState.FAILED, at=context.now(), error=why)
