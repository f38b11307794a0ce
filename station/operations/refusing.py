"""Refusing a calibration: it stays to be looked at, and cannot come into force."""

from sqlalchemy.orm import Session

from station.errors import InputUnusable, StateConflict
from station.operations.collaborators import Station
from station.store import (
    Action,
    Actor,
    Calibration,
    CalibrationState,
    RigCalibration,
    active,
    active_rig,
    audit,
    the,
)

_LONGEST = 500


def refuse_calibration(
    station: Station, calibration_id: str, *, why: str, by: Actor
) -> Calibration:
    """Refuse a calibration of a sensor; the same refusal of the same person changes nothing.

    Raises
    ------
    InputUnusable
        If no reason is given, or it is too long.
    NotFound
        If there is no such calibration.
    StateConflict
        If it is not ready, is in force, or was refused for another reason.
    """
    with station.store.change() as session:
        row = the(session, Calibration, calibration_id)
        present = active(session, row.sensor)
        in_force = present is not None and present.calibration_id == row.id
        _refuse(station, session, row, "calibration", why, by, in_force=in_force)
        return row


def refuse_rig_calibration(
    station: Station, calibration_id: str, *, why: str, by: Actor
) -> RigCalibration:
    """Refuse a calibration of a rig; as `refuse_calibration`, which see for what it raises."""
    with station.store.change() as session:
        row = the(session, RigCalibration, calibration_id)
        present = active_rig(session, row.rig)
        in_force = present is not None and present.rig_calibration_id == row.id
        _refuse(station, session, row, "rig calibration", why, by, in_force=in_force)
        return row


def _refuse(
    station: Station,
    session: Session,
    row: Calibration | RigCalibration,
    kind: str,
    why: str,
    by: Actor,
    *,
    in_force: bool,
) -> None:
    why = why.strip()
    if not 0 < len(why) <= _LONGEST:
        raise InputUnusable(
            f"a reason of {len(why)} characters; allowed: 1 to {_LONGEST}, say why it is refused"
        )
    if (row.refused_by, row.refused_why) == (by.name, why):
        return
    _ensure_can_be_refused(row, in_force=in_force)
    row.refused_at, row.refused_by, row.refused_why = station.now(), by.name, why
    audit(session, Action.REFUSE, kind, row.id, by=by, at=station.now(), after={"why": why})


def _ensure_can_be_refused(row: Calibration | RigCalibration, *, in_force: bool) -> None:
    if row.state is not CalibrationState.READY:
        raise StateConflict(
            f"calibration {row.id} is {row.state}; only a ready one can be refused",
            state=row.state,
        )
    if in_force:
        raise StateConflict(
            f"calibration {row.id} is in force; bring another one into force, then refuse it",
            state="active",
        )
    if row.refused_at is not None:
        raise StateConflict(
            f"calibration {row.id} was refused by {row.refused_by} ({row.refused_why})",
            state="refused",
        )
