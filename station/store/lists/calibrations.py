"""Calibrations of sensors and of rigs, and when they came into force, the newest first."""

from sqlalchemy import select
from sqlalchemy.orm import Session, defer

from station.store.lists.paging import Cursor, Page, newest_page, page_of
from station.store.tables import Activation, Calibration, RigActivation, RigCalibration


def calibrations_page(
    session: Session, *, limit: int, before: Cursor | None = None, sensor: str | None = None
) -> Page[Calibration]:
    """Return calibrations of sensors by when they were ordered, without their documents."""
    query = select(Calibration).options(defer(Calibration.document, raiseload=True))
    if sensor is not None:
        query = query.where(Calibration.sensor == sensor)
    return newest_page(
        session, query, Calibration.created_at, Calibration.id, limit=limit, before=before
    )


def activations_page(
    session: Session, sensor: str, *, limit: int, before: int | None = None
) -> Page[Activation]:
    """Return the calibrations that came into force on a sensor, the last one first."""
    query = select(Activation).where(Activation.sensor == sensor)
    query = query if before is None else query.where(Activation.version < before)
    return page_of(session, query.order_by(Activation.version.desc()), limit)


def rig_calibrations_page(
    session: Session, *, limit: int, before: Cursor | None = None, rig: str | None = None
) -> Page[RigCalibration]:
    """Return calibrations of rigs by when they were made, without their documents."""
    query = select(RigCalibration).options(defer(RigCalibration.document, raiseload=True))
    if rig is not None:
        query = query.where(RigCalibration.rig == rig)
    return newest_page(
        session, query, RigCalibration.created_at, RigCalibration.id, limit=limit, before=before
    )


def rig_activations_page(
    session: Session, rig: str, *, limit: int, before: int | None = None
) -> Page[RigActivation]:
    """Return the calibrations that came into force on a rig, the last one first."""
    query = select(RigActivation).where(RigActivation.rig == rig)
    query = query if before is None else query.where(RigActivation.version < before)
    return page_of(session, query.order_by(RigActivation.version.desc()), limit)
