"""Putting together what a decision rests on, from the store."""

import math
from collections.abc import Iterable
from dataclasses import asdict
from datetime import datetime

from sqlalchemy.orm import Session

from measure import PieceVerdict
from station.documents import CalibrationDocument
from station.operations import last_good_check
from station.recalibration import Difference, Evidence, Outcome, PieceFindings, largest_ratio
from station.store import (
    Calibration,
    JsonObject,
    Recalibration,
    RecalibrationState,
    active,
    the,
)
from station.store.recalibrations import decided_against
from station.worker.comparing import sheet_difference, soundness_of, whole_difference
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
    settings = context.settings.recalibration
    ratio = largest_ratio(settings.gates.false_alarm)
    compared = {
        "sheet": _kept(sheet_difference(present, new)),
        "whole": _kept(
            whole_difference(present, new, camera_kept=settings.of(row.sensor).camera == "in_force")
        ),
        "confirmed": _agreeing(new, earlier, ratio),
    }
    with context.store.change() as session:
        found = the(session, Recalibration, row.id)
        found.findings = {**found.findings, **compared}


def _agreeing(
    new: CalibrationDocument, earlier: Iterable[CalibrationDocument], ratio: float
) -> int:
    """Count those, from the newest back, that differ from the new one by their scatter alone."""
    count = 0
    for each in earlier:
        apart = sheet_difference(each, new)
        if not apart.rms_mm <= ratio * apart.expected_mm:
            break
        count += 1
    return count


def _telling(session: Session, row: Recalibration) -> list[Recalibration]:
    """Return the earlier recalibrations against what is in force that tell of it, newest first."""
    if row.present_version is None:
        return []
    return [
        each
        for each in decided_against(session, row.sensor, row.present_version)
        if each.id != row.id and _tells(each)
    ]


def _tells(row: Recalibration) -> bool:
    # What a person has refused was a finding of the pictures, not of the sensor.
    if row.outcome is None or row.state is RecalibrationState.REFUSED:
        return False
    return Outcome(row.outcome).tells


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
        sheet=_difference(findings.get("sheet")),
        whole=_difference(findings.get("whole")),
        piece=_piece(context, row),
        present_age_days=None if present is None else _days(present.created_at, now),
        unchecked_days=None if checked_at is None else _days(checked_at, now),
        drifting=bool(telling) and telling[0].outcome == Outcome.DRIFTED,
        confirmed=findings.get("confirmed", 0),
    )


def _kept(difference: Difference) -> dict[str, object]:
    """Return a comparison as JSON has it: no database takes a NaN in it."""
    told = {**asdict(difference), "largest_at_px": None}
    if math.isfinite(difference.rms_mm):
        told["largest_at_px"] = list(difference.largest_at_px)
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in told.items()
    }


def _difference(kept: JsonObject | None) -> Difference | None:
    if kept is None:
        return None
    told: JsonObject = {name: math.nan if value is None else value for name, value in kept.items()}
    u, v = kept["largest_at_px"] or (math.nan, math.nan)
    return Difference(**{**told, "largest_at_px": (u, v)})


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
