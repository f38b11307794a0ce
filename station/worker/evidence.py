"""Putting together what a decision rests on, from the store."""

from collections.abc import Iterable
from dataclasses import asdict
from datetime import datetime

from sqlalchemy.orm import Session

from measure import PieceVerdict
from station.documents import CalibrationDocument
from station.operations import last_good_check
from station.recalibration import Difference, Evidence, Outcome, PieceFindings, largest_ratio
from station.store import Calibration, Recalibration, active, decided_against, the
from station.worker.comparing import difference_of, soundness_of
from station.worker.context import WorkContext
from station.worker.quiet import Quiet

_DAY_S = 86_400.0


def note_comparison(context: WorkContext, row: Recalibration, quiet: Quiet) -> None:
    """Note how far the new calibration and the one in force differ, and who agrees with it."""
    if row.calibration_id is None or row.present_id is None:
        return
    quiet(0.0, "comparing")
    with context.store.look() as session:
        new, present = (_document(session, name) for name in (row.calibration_id, row.present_id))
        earlier = [_document(session, name) for name in _drifts(session, row)]
    ratio = largest_ratio(context.settings.recalibration.gates.false_alarm)
    confirmed = _agreeing(new, earlier, ratio)
    difference = difference_of(present, new)
    with context.store.change() as session:
        found = the(session, Recalibration, row.id)
        compared = {"difference": asdict(difference), "confirmed": confirmed}
        found.findings = {**found.findings, **compared}


def _agreeing(
    new: CalibrationDocument, earlier: Iterable[CalibrationDocument], ratio: float
) -> int:
    """Count those, from the newest back, that differ from the new one by their scatter alone."""
    count = 0
    for each in earlier:
        apart = difference_of(each, new)
        if not apart.rms_mm <= ratio * apart.expected_mm:
            break
        count += 1
    return count


def _telling(session: Session, row: Recalibration) -> list[Recalibration]:
    """Return the earlier recalibrations against what is in force that tell of it, newest first."""
    if row.present_version is None:
        return []
    silent = {Outcome.DOUBTFUL, Outcome.NOTHING_NEW}
    return [
        each
        for each in decided_against(session, row.sensor, row.present_version)
        if each.id != row.id and each.outcome not in silent
    ]


def _drifts(session: Session, row: Recalibration) -> list[str]:
    """Return the calibrations that found a drift, in a row up to now, newest first."""
    found = []
    for each in _telling(session, row):
        if each.outcome != Outcome.DRIFTED or each.calibration_id is None:
            break
        found.append(each.calibration_id)
    return found


def evidence_of(context: WorkContext, row: Recalibration) -> Evidence:
    """Return what the decision rests on."""
    findings, now = row.findings, context.now()
    with context.store.look() as session:
        new = None if row.calibration_id is None else _document(session, row.calibration_id)
        present = None if row.present_id is None else the(session, Calibration, row.present_id)
        activation = active(session, row.sensor)
        checked_at = None if activation is None else last_good_check(session, activation)
        telling = _telling(session, row)
    taken_at = row.pictures_at or row.ordered_at
    return Evidence(
        new=None if new is None else soundness_of(new, pictures_at=taken_at, now=now),
        unsolved=findings.get("unsolved"),
        difference=_difference(findings.get("difference")),
        piece=_piece(context, row),
        present_age_days=None if present is None else _days(present.created_at, now),
        unchecked_days=None if checked_at is None else _days(checked_at, now),
        drifting=bool(telling) and telling[0].outcome == Outcome.DRIFTED,
        confirmed=findings.get("confirmed", 0),
    )


def _difference(kept: dict[str, object] | None) -> Difference | None:
    return None if kept is None else Difference(**kept)  # type: ignore[arg-type]  # as `asdict` made it


def _piece(context: WorkContext, row: Recalibration) -> PieceFindings:
    settings = context.settings.recalibration.of(row.sensor).piece
    kept = row.findings.get("piece", {})
    verdicts = {
        name: PieceVerdict(kept[name]) for name in ("by_new", "by_present") if kept.get(name)
    }
    return PieceFindings(**verdicts, required=settings is not None and settings.required)


def _days(since: datetime, now: datetime) -> float:
    return (now - since).total_seconds() / _DAY_S


def _document(session: Session, calibration_id: str) -> CalibrationDocument:
    row = the(session, Calibration, calibration_id)
    return CalibrationDocument.model_validate_json(row.document or "")
