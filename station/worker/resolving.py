"""Solving the new calibration of a recalibration."""

from calib import CalibError, CameraModel, Method, Target
from station.documents import CalibrationDocument
from station.errors import InputUnusable, RecordingUnreadable
from station.pipeline import CalibrationOutcome
from station.store import (
    Calibration,
    CalibrationPoints,
    CalibrationState,
    Job,
    JobState,
    Recalibration,
    Recording,
    the,
)
from station.worker.context import WorkContext
from station.worker.quiet import Quiet


def solve(context: WorkContext, row: Recalibration, quiet: Quiet) -> None:
    """Solve the calibration and keep it, or note why there is none; once, however often called."""
    if row.calibration_id is not None or row.taken is None or not row.taken["recordings"]:
        return
    try:
        outcome = _calibrate(context, row, quiet)
    except (CalibError, InputUnusable, RecordingUnreadable) as error:
        _note(context, row, unsolved=str(error))
        return
    _keep(context, row, outcome)


def _calibrate(context: WorkContext, row: Recalibration, quiet: Quiet) -> CalibrationOutcome:
    taken = row.taken or {}
    with context.store.look() as session:
        paths = [the(session, Recording, name).path for name in taken["recordings"]]
    sensor = context.settings.sensor(row.sensor)
    return context.mathematics.calibrate(
        [context.layout.root / path for path in paths],
        Target.parse(taken["target"]),
        sensor=row.sensor,
        method=Method(context.settings.recalibration.of(row.sensor).method),
        laser_off=(),
        mounting=None if sensor is None else sensor.mounting,
        progress=quiet,
        camera=_camera_known(context, row),
    )


def _camera_known(context: WorkContext, row: Recalibration) -> CameraModel | None:
    """Return the camera of the calibration in force, with its covariance, as a prior."""
    if context.settings.recalibration.of(row.sensor).camera == "solve" or row.present_id is None:
        return None
    with context.store.look() as session:
        document = the(session, Calibration, row.present_id).document
    return CalibrationDocument.model_validate_json(document or "").camera.model()


def _keep(context: WorkContext, row: Recalibration, outcome: CalibrationOutcome) -> None:
    taken = row.taken or {}
    with context.store.change() as session:
        if the(session, Job, row.job_id).state is not JobState.RUNNING:
            return
        session.add(
            Calibration(
                id=row.id,
                state=CalibrationState.READY,
                sensor=row.sensor,
                target=taken["target"],
                method=context.settings.recalibration.of(row.sensor).method,
                recording_ids={"recordings": taken["recordings"], "laser_off": []},
                created_at=context.now(),
                job_id=row.job_id,
                document=outcome.document.model_dump_json(),
                passed=outcome.document.passed,
            )
        )
        session.flush()
        session.add(CalibrationPoints(calibration_id=row.id, csv=outcome.points_csv))
        the(session, Recalibration, row.id).calibration_id = row.id


def _note(context: WorkContext, row: Recalibration, *, unsolved: str) -> None:
    with context.store.change() as session:
        found = the(session, Recalibration, row.id)
        found.findings = {**found.findings, "unsolved": unsolved}
