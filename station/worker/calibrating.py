"""The job that solves a calibration."""

from dataclasses import dataclass
from pathlib import Path

from calib import Method, Target
from station.pipeline import CalibrationOutcome
from station.settings import MountingSettings
from station.store import (
    CALIBRATION,
    Calibration,
    CalibrationPoints,
    CalibrationState,
    Job,
    JobState,
    Recording,
    end,
    the,
)
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line


@dataclass(frozen=True, slots=True)
class _Order:
    sensor: str
    target: Target
    method: Method
    sources: list[Path]
    laser_off: list[Path]
    mounting: MountingSettings | None


def calibrate(context: WorkContext, job_id: str) -> None:
    """Solve the calibration of a job and keep it, or why there is none."""
    job = begin(context, job_id)
    if job is None:
        return
    try:
        outcome = _solve(context, job)
    except JobCancelled:
        return
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        fail_calibration(context, job_id, one_line(error, job_id))
        return
    _keep(context, job, outcome)


def _solve(context: WorkContext, job: Job) -> CalibrationOutcome:
    order = _order(context, job)
    return context.mathematics.calibrate(
        order.sources,
        order.target,
        sensor=order.sensor,
        method=order.method,
        laser_off=order.laser_off,
        mounting=order.mounting,
        progress=JobProgress(context, job.id),
    )


def _order(context: WorkContext, job: Job) -> _Order:
    with context.store.look() as session:
        calibration = the(session, Calibration, job.subject)

        def paths(kind: str) -> list[Path]:
            names = calibration.recording_ids[kind]
            return [context.layout.root / the(session, Recording, name).path for name in names]

        settings = context.settings.sensor(calibration.sensor)
        return _Order(
            sensor=calibration.sensor,
            target=Target.parse(calibration.target),
            method=Method(calibration.method),
            sources=paths("recordings"),
            laser_off=paths("laser_off"),
            mounting=None if settings is None else settings.mounting,
        )


def _keep(context: WorkContext, job: Job, outcome: CalibrationOutcome) -> None:
    with context.store.change() as session:
        present = the(session, Job, job.id)
        if present.state is not JobState.RUNNING:  # cancelled while the last step ran
            return
        calibration = the(session, Calibration, job.subject)
        CALIBRATION.check(calibration.id, calibration.state, CalibrationState.READY)
        calibration.state = CalibrationState.READY
        calibration.document = outcome.document.model_dump_json()
        calibration.passed = outcome.document.passed
        session.add(CalibrationPoints(calibration_id=calibration.id, csv=outcome.points_csv))
        end(present, JobState.DONE, at=context.now())


def fail_calibration(context: WorkContext, job_id: str, why: str) -> None:
    """End a job without a calibration."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state not in {JobState.QUEUED, JobState.RUNNING}:
            return
        calibration = the(session, Calibration, job.subject)
        CALIBRATION.check(calibration.id, calibration.state, CalibrationState.FAILED)
        calibration.state, calibration.reason = CalibrationState.FAILED, why
        end(job, JobState.FAILED, at=context.now(), error=why)
