"""Which calibration is in force on a sensor or a rig, and how another follows, none lost."""

from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.errors import InputUnusable, StateConflict, VersionConflict, VersionMissing
from station.store.audit import Action, Actor, audit
from station.store.states import CalibrationState
from station.store.tables import (
    Activation,
    Calibration,
    JsonObject,
    RigActivation,
    RigCalibration,
)


def active(session: Session, sensor: str) -> Activation | None:
    """Return the activation in force on a sensor, or None before the first."""
    return session.scalar(
        select(Activation)
        .where(Activation.sensor == sensor)
        .order_by(Activation.version.desc())
        .limit(1)
    )


def activate(
    session: Session,
    calibration: Calibration,
    *,
    sensor: str,
    seen: int | None,
    by: Actor,
    at: datetime,
) -> Activation:
    """Bring a calibration into force on a sensor.

    Parameters
    ----------
    seen
        Version of the activation that the caller saw in force; None where it saw none.

    Raises
    ------
    StateConflict
        If the calibration is not ready, or was refused.
    InputUnusable
        If it is a calibration of another sensor.
    VersionMissing
        If one is in force and the caller does not say which it saw.
    VersionConflict
        If another than the one it saw is in force.
    """
    _ensure_fits(calibration, sensor)
    _ensure_not_refused(calibration)
    present = active(session, sensor)
    new = Activation(
        sensor=sensor,
        version=_next_version(f"sensor {sensor}", present, seen),
        calibration_id=calibration.id,
        activated_at=at,
        activated_by=by.name,
    )
    session.add(new)
    was = None if present is None else _state_of(present.version, present.calibration_id)
    now = _state_of(new.version, calibration.id)
    audit(session, Action.ACTIVATE, "sensor", sensor, by=by, at=at, before=was, after=now)
    session.flush()
    return new


def active_rig(session: Session, rig: str) -> RigActivation | None:
    """Return the activation in force on a rig, or None before the first."""
    return session.scalar(
        select(RigActivation)
        .where(RigActivation.rig == rig)
        .order_by(RigActivation.version.desc())
        .limit(1)
    )


def activate_rig(
    session: Session,
    calibration: RigCalibration,
    *,
    rig: str,
    seen: int | None,
    by: Actor,
    at: datetime,
) -> RigActivation:
    """Bring a rig's calibration into force; as `activate`, which see for what it raises."""
    _ensure_ready(f"calibration {calibration.id} of a rig", calibration.state)
    _ensure_not_refused(calibration)
    if calibration.rig != rig:
        raise InputUnusable(
            f"calibration {calibration.id} is of rig {calibration.rig}, not of {rig}; "
            "give one of the same rig"
        )
    present = active_rig(session, rig)
    new = RigActivation(
        rig=rig,
        version=_next_version(f"rig {rig}", present, seen),
        rig_calibration_id=calibration.id,
        activated_at=at,
        activated_by=by.name,
    )
    session.add(new)
    was = None if present is None else _state_of(present.version, present.rig_calibration_id)
    now = _state_of(new.version, calibration.id)
    audit(session, Action.ACTIVATE, "rig", rig, by=by, at=at, before=was, after=now)
    session.flush()
    return new


def _state_of(version: int, calibration: str) -> JsonObject:
    """Return what the audit trail keeps of an activation."""
    return {"version": version, "calibration": calibration}


def _next_version(of: str, present: Activation | RigActivation | None, seen: int | None) -> int:
    version = 0 if present is None else present.version
    if seen is None and present is not None:
        raise VersionMissing(
            f"{of} has an active calibration, version {version}; "
            "read it and send its ETag in If-Match"
        )
    if seen is not None and seen != version:
        raise VersionConflict(
            f"the active calibration of {of} is at version {version}, not {seen}: "
            "somebody changed it meanwhile; read it again and decide anew"
        )
    return version + 1


def _ensure_ready(what: str, state: CalibrationState) -> None:
    if state is not CalibrationState.READY:
        raise StateConflict(f"{what} is {state}; only a ready one can be active", state=state)


def _ensure_not_refused(calibration: Calibration | RigCalibration) -> None:
    if calibration.refused_at is not None:
        raise StateConflict(
            f"calibration {calibration.id} was refused by {calibration.refused_by} "
            f"({calibration.refused_why}); calibrate again",
            state="refused",
        )


def _ensure_fits(calibration: Calibration, sensor: str) -> None:
    _ensure_ready(f"calibration {calibration.id}", calibration.state)
    if calibration.sensor != sensor:
        raise InputUnusable(
            f"calibration {calibration.id} is of sensor {calibration.sensor}, not of {sensor}; "
            "give one of the same sensor"
        )


def activation_of(session: Session, sensor: str, version: int) -> Activation:
    """Return an activation of a sensor that is known to have been."""
    return session.scalars(
        select(Activation).where(Activation.sensor == sensor).where(Activation.version == version)
    ).one()
