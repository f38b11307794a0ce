"""Looking up recalibrations, and what they left: activations, alarms, piece checks."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import Select, func, select
from sqlalchemy.orm import Session

from station.store.activations import active
from station.store.states import JOB, RecalibrationState
from station.store.tables import (
    Activation,
    Calibration,
    Job,
    KeptPieceCheck,
    Recalibration,
    Recording,
)

RUNNING = (RecalibrationState.WAITING, RecalibrationState.RUNNING)


def running_recalibration(session: Session, sensor: str) -> Recalibration | None:
    """Return the recalibration of a sensor that has not come to its end."""
    return session.scalar(_of(sensor).where(Recalibration.state.in_(RUNNING)).limit(1))


def asking_recalibrations(session: Session, sensor: str) -> Sequence[Recalibration]:
    """Return the recalibrations of a sensor that wait for a person, the newest first."""
    query = _of(sensor).where(Recalibration.state == RecalibrationState.ASKING)
    return session.scalars(query).all()


def last_decided(session: Session, sensor: str) -> Recalibration | None:
    """Return the last recalibration of a sensor that came to a decision."""
    return session.scalar(_of(sensor).where(Recalibration.outcome.is_not(None)).limit(1))


def decided_against(session: Session, sensor: str, version: int) -> Sequence[Recalibration]:
    """Return what was decided against an activation of a sensor, the newest first."""
    query = _of(sensor).where(Recalibration.outcome.is_not(None))
    return session.scalars(query.where(Recalibration.present_version == version)).all()


def settled_until(session: Session, sensor: str) -> datetime | None:
    """Return the last moment of the schedule that a recalibration of a sensor was made for."""
    return session.scalar(
        select(func.max(Recalibration.due_at)).where(Recalibration.sensor == sensor)
    )


def recordings_taken(session: Session, sensor: str) -> set[str]:
    """Return the recordings that recalibrations of a sensor were made from already."""
    taken = session.scalars(
        select(Recalibration.taken)
        .where(Recalibration.sensor == sensor)
        .where(Recalibration.outcome.is_not(None))
    )
    return {name for each in taken if each is not None for name in each["recordings"]}


def recordings_recalibrated(session: Session) -> set[str]:
    """Return what recalibrations need that have not ended, or that wait for a person.

    Whoever is to answer looks at the pictures, and a calibration that is then brought into force
    must have what it was made from.  A job that measures passes again needs what they recorded.
    """
    taken = session.scalars(
        select(Recalibration.taken).where(
            Recalibration.state.in_([*RUNNING, RecalibrationState.ASKING])
        )
    )
    needed = {
        name
        for each in taken
        if each is not None
        for kind in ("named", "recordings", "piece")
        for name in each.get(kind) or []
    }
    compared_with = session.scalars(
        select(Recalibration.present_id)
        .join(Job, Recalibration.measuring_job_id == Job.id)
        .where(Job.state.in_(JOB.unfinished))
    ).all()
    # Whole passes: of a rig all sensors are measured together.
    of_sensor = select(Recording.pass_id).where(Recording.calibration_id.in_(compared_with))
    needed.update(session.scalars(select(Recording.id).where(Recording.pass_id.in_(of_sensor))))
    return needed


def first_piece_check(session: Session, calibration_id: str) -> KeptPieceCheck | None:
    """Return the first check of the reference piece by a calibration."""
    return session.scalar(
        select(KeptPieceCheck)
        .where(KeptPieceCheck.calibration_id == calibration_id)
        .order_by(KeptPieceCheck.id)
        .limit(1)
    )


def alarm_of(session: Session, sensor: str) -> Recalibration | None:
    """Return the recalibration that says the calibration in force may measure wrongly, or None.

    One against a calibration that is no longer in force raises no alarm any more, nor does one
    that a person has refused.
    """
    last, present = last_decided(session, sensor), active(session, sensor)
    if last is None or present is None or not last.alarm:
        return None
    if last.state is RecalibrationState.REFUSED:
        return None
    return last if last.present_version == present.version else None


def recordings_under(
    session: Session, sensor: str, calibration_id: str, since: datetime
) -> Sequence[Recording]:
    """Return a sensor's recordings of passes made under a calibration since then, oldest first."""
    return session.scalars(
        select(Recording)
        .where(Recording.sensor == sensor)
        .where(Recording.pass_id.is_not(None))
        .where(Recording.calibration_id == calibration_id)
        .where(Recording.opened_at >= since)
        .where(Recording.deleted_at.is_(None))
        .order_by(Recording.opened_at, Recording.id)
    ).all()


def reasons_for(
    session: Session, activations: Sequence[Activation]
) -> dict[int, tuple[Calibration, Recalibration | None]]:
    """Return, by version, the calibrations of a sensor's activations, and what brought them."""
    if not activations:
        return {}
    versions = {row.version: row.calibration_id for row in activations}
    brought = session.scalars(
        select(Recalibration)
        .where(Recalibration.sensor == activations[0].sensor)
        .where(Recalibration.activated_version.in_(versions))
    )
    by_version = {row.activated_version: row for row in brought}
    calibrations = session.scalars(
        select(Calibration).where(Calibration.id.in_(set(versions.values())))
    )
    by_id = {row.id: row for row in calibrations}
    return {
        version: (by_id[calibration_id], by_version.get(version))
        for version, calibration_id in versions.items()
    }


def _of(sensor: str) -> Select[Recalibration]:
    return (
        select(Recalibration)
        .where(Recalibration.sensor == sensor)
        .order_by(Recalibration.ordered_at.desc(), Recalibration.id.desc())
    )
