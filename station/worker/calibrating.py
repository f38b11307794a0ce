"""The job that solves a calibration."""

from dataclasses import dataclass
from pathlib import Path

from calib import Method, Target
from station.pipeline import CalibrationOutcome
from station.settings import MountingSettings
from station.store import Calibration, CalibrationPoints, Job, Recording, the
from station.worker.calibrated import fail, keep
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
    points = CalibrationPoints(calibration_id=job.subject, csv=outcome.points_csv)
    keep(context, job_id, Calibration, outcome.document, [points])


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


def fail_calibration(context: WorkContext, job_id: str, why: str) -> None:
    """End a job without a calibration."""
    fail(context, job_id, Calibration, why)
