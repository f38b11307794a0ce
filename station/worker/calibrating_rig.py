"""The job that calibrates a rig."""

from pathlib import Path

from calib import Target
from measure import Side
from station.documents import CalibrationDocument
from station.errors import InputUnusable
from station.pipeline import RigOrder
from station.settings import StationSettings
from station.store import (
    Calibration,
    Job,
    JsonObject,
    Recording,
    RigCalibration,
    RigCalibrationPoints,
    the,
)
from station.worker.calibrated import fail, keep
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line


def calibrate_rig(context: WorkContext, job_id: str) -> None:
    """Calibrate the rig of a job and keep it, or why there is none."""
    job = begin(context, job_id)
    if job is None:
        return
    try:
        sources, order = _order(context, job)
        outcome = context.mathematics.calibrate_rig(
            sources, order, progress=JobProgress(context, job.id)
        )
    except JobCancelled:
        return
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        fail_rig_calibration(context, job_id, one_line(error, job_id))
        return
    points = [
        RigCalibrationPoints(rig_calibration_id=job.subject, sensor=sensor, csv=text)
        for sensor, text in outcome.points_csv.items()
    ]
    keep(context, job_id, RigCalibration, outcome.document, points)


def _order(context: WorkContext, job: Job) -> tuple[list[Path], RigOrder]:
    with context.store.look() as session:
        row = the(session, RigCalibration, job.subject)
        ordered: JsonObject = row.ordered or {}
        sources = [
            context.layout.root / the(session, Recording, name).path
            for names in ordered["recordings"].values()
            for name in names
        ]
        documents = [
            the(session, Calibration, each).document for each in ordered["calibrations"].values()
        ]
    calibrations = [CalibrationDocument.model_validate_json(each or "") for each in documents]
    return sources, _rig_order(context.settings, row.rig, ordered, calibrations)


def _rig_order(
    settings: StationSettings,
    rig_id: str,
    ordered: JsonObject,
    calibrations: list[CalibrationDocument],
) -> RigOrder:
    rig = settings.rig(rig_id)
    if rig is None:
        raise InputUnusable(f"rig {rig_id!r} was taken out of the settings; order it anew")
    boards = [Target.parse(ordered["targets"][each.sensor]) for each in calibrations]
    return RigOrder(
        rig=rig.id,
        calibrations=tuple(calibrations),
        boards=tuple(boards[:1] if ordered["same_board"] else boards),
        same_board=ordered["same_board"],
        board_sigma_mm=ordered["board_sigma_mm"],
        anchor=settings.anchor_of(rig),
        side=Side(settings.side_of(rig)),
        sigma_vibration_mm=rig.sigma_vibration_mm,
        sigma_vibration_rad=rig.sigma_vibration_rad,
    )


def fail_rig_calibration(context: WorkContext, job_id: str, why: str) -> None:
    """End a job without a rig."""
    fail(context, job_id, RigCalibration, why)
