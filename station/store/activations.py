"""Which calibration is in force on a sensor, and how another follows without a lost update."""

from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.errors import InputUnusable, StateConflict, VersionConflict, VersionMissing
from station.store.states import CalibrationState
from station.store.tables import Activation, Calibration


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
    by: str,
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
        If the calibration is not ready.
    InputUnusable
        If it is a calibration of another sensor.
    VersionMissing
        If one is in force and the caller does not say which it saw.
    VersionConflict
        If another than the one it saw is in force.
    """
    _ensure_fits(calibration, sensor)
    present = active(session, sensor)
    version = 0 if present is None else present.version
    if seen is None and present is not None:
        raise VersionMissing(
            f"sensor {sensor} has an active calibration, version {version}; "
            "read it and send its ETag in If-Match"
        )
    if seen is not None and seen != version:
        raise VersionConflict(
            f"the active calibration of sensor {sensor} is at version {version}, not {seen}: "
            "somebody changed it meanwhile; read it again and decide anew"
        )
    new = Activation(
        sensor=sensor,
        version=version + 1,
        calibration_id=calibration.id,
        activated_at=at,
        activated_by=by,
    )
    session.add(new)
    session.flush()
    return new


def _ensure_fits(calibration: Calibration, sensor: str) -> None:
    if calibration.state is not CalibrationState.READY:
        raise StateConflict(
            f"calibration {calibration.id} is {calibration.state}; only a ready one can be active",
            state=calibration.state,
        )
    if calibration.sensor != sensor:
        raise InputUnusable(
            f"calibration {calibration.id} is of sensor {calibration.sensor}, not of {sensor}; "
            "give one of the same sensor"
        )
