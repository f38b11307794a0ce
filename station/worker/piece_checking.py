"""The reference piece in a recalibration: what the new and the old calibration make of it."""

from pathlib import Path

from calib import CalibError
from measure import MeasureError
from station.documents import CalibrationDocument, PieceCheck, PieceDocument
from station.errors import StationError
from station.pipeline import check_piece
from station.settings import PieceSettings
from station.store import Calibration, KeptPieceCheck, Recalibration, Recording, the
from station.store.recalibrations import first_piece_check
from station.worker.context import WorkContext
from station.worker.quiet import Quiet

_CALIBRATION = {"by_new": "new calibration", "by_present": "calibration in force"}


def check_piece_of(context: WorkContext, row: Recalibration, quiet: Quiet) -> None:
    """Check the piece with both calibrations, where there is one; keep the checks, once."""
    settings = context.settings.recalibration.of(row.sensor).piece
    if settings is None or row.taken is None or not row.taken["piece"]:
        return
    if "piece" in row.findings:
        return
    try:
        checks = _check_both(context, row, settings, quiet)
    except (CalibError, MeasureError, StationError) as error:
        _keep(context, row, {}, [f"the reference piece was not checked: {error}"])
        return
    told = [f"the piece by the {_CALIBRATION[by]}: {each.reason}" for by, each in checks.items()]
    _keep(context, row, checks, told)


def _check_both(
    context: WorkContext, row: Recalibration, settings: PieceSettings, quiet: Quiet
) -> dict[str, PieceCheck]:
    piece = PieceDocument.read(settings.certificate).piece()
    with context.store.look() as session:
        paths = [the(session, Recording, name).path for name in (row.taken or {})["piece"]]
    sources: list[Path] = [context.layout.root / path for path in paths]
    checks = {}
    for name, calibration_id in _by(row).items():
        calibration, since = _calibration(context, calibration_id, settings)
        checks[name] = check_piece(
            sources,
            calibration,
            piece,
            limit_mm=settings.limit_mm,
            since=since,
            progress=quiet,
        )
    return checks


def _by(row: Recalibration) -> dict[str, str]:
    both = {"by_new": row.calibration_id, "by_present": row.present_id}
    return {name: value for name, value in both.items() if value is not None}


def _calibration(
    context: WorkContext, calibration_id: str, settings: PieceSettings
) -> tuple[CalibrationDocument, PieceCheck | None]:
    """Return a calibration, and its first check where the holder has kept the piece since."""
    with context.store.look() as session:
        document = the(session, Calibration, calibration_id).document
        first = first_piece_check(session, calibration_id)
    since = None
    if settings.holder_kept and first is not None:
        since = PieceCheck.model_validate_json(first.document)
    return CalibrationDocument.model_validate_json(document or ""), since


def _keep(
    context: WorkContext, row: Recalibration, checks: dict[str, PieceCheck], remarks: list[str]
) -> None:
    by = _by(row)
    with context.store.change() as session:
        for name, check in checks.items():
            session.add(
                KeptPieceCheck(
                    sensor=row.sensor,
                    calibration_id=by[name],
                    recalibration_id=row.id,
                    checked_at=context.now(),
                    verdict=check.verdict.value,
                    document=check.model_dump_json(),
                )
            )
        found = the(session, Recalibration, row.id)
        told = [*found.findings.get("remarks", []), *remarks]
        verdicts = {name: check.verdict.value for name, check in checks.items()}
        found.findings = {**found.findings, "piece": verdicts, "remarks": told}
