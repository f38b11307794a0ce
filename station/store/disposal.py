"""Which recordings have served their purpose: what they were made for is in the store."""

from collections.abc import Iterator, Mapping, Sequence

from sqlalchemy import func, or_, select
from sqlalchemy.orm import Session

from station.store.measured import recordings_replayed
from station.store.recalibrations import recordings_recalibrated
from station.store.states import CalibrationState, PassState
from station.store.tables import (
    Activation,
    Calibration,
    Following,
    Measurement,
    Pass,
    Recording,
    RigActivation,
    RigCalibration,
)


def measured_recordings(session: Session) -> Sequence[Recording]:
    """Return the recordings of passes that were measured and are still there, oldest first.

    Measured with the calibration they were recorded under; one without a frame counts too. A rig's
    wheel is in the row of one of its recordings, and was measured from all of them. One that was
    measured while it was written, and then not to its end, does not count.
    """
    followed = select(Following.recording_id)
    measured = (
        select(Measurement.id)
        .where(Measurement.recording_id == Recording.id)
        .where(Measurement.calibration_id == Recording.calibration_id)
        .exists()
    )
    on_rig = (
        select(Measurement.id)
        .where(Measurement.pass_id == Recording.pass_id)
        .where(Measurement.rig_calibration_id == Recording.rig_calibration_id)
        .exists()
    )
    return session.scalars(
        select(Recording)
        .join(Pass, Recording.pass_id == Pass.id)
        .where(Pass.state.in_([PassState.DONE, PassState.RECOVERED]))
        .where(Recording.closed_at.is_not(None))
        .where(Recording.deleted_at.is_(None))
        .where(or_(measured, on_rig, Recording.recorded == 0))
        .where(Recording.id.not_in(followed))
        .order_by(Recording.opened_at, Recording.id)
    ).all()


def failed_recordings(session: Session) -> Sequence[Recording]:
    """Return the recordings of passes that failed and are still there, oldest first.

    None that a calibration in force, or one that is being solved, was made from, nor one that is
    being replayed, or that a recalibration needs.
    """
    _, kept = _calibrated_from(session)
    found = session.scalars(
        select(Recording)
        .join(Pass, Recording.pass_id == Pass.id)
        .where(Pass.state == PassState.FAILED)
        .where(Recording.closed_at.is_not(None))
        .where(Recording.deleted_at.is_(None))
        .order_by(Recording.opened_at, Recording.id)
    )
    return [row for row in found if row.id not in kept]


def uploaded_recordings(session: Session) -> Sequence[Recording]:
    """Return the uploaded recordings that are still there and nothing needs, oldest first."""
    _, kept = _calibrated_from(session)
    found = session.scalars(
        select(Recording)
        .where(Recording.sha256.is_not(None))
        .where(Recording.deleted_at.is_(None))
        .order_by(Recording.opened_at, Recording.id)
    )
    return [row for row in found if row.id not in kept]


def disposable_recordings(session: Session) -> Sequence[Recording]:
    """Return the recordings that may be deleted, oldest first.

    Measured ones, and those of calibration sessions that a calibration was solved from; but none
    that a calibration in force, or one that is being solved, was made from, nor one that is being
    replayed, or that a recalibration needs.
    """
    used, kept = _calibrated_from(session)
    of_sessions = session.scalars(
        select(Recording)
        .where(Recording.session_id.is_not(None))
        .where(Recording.closed_at.is_not(None))
        .where(Recording.deleted_at.is_(None))
    )
    found = [row for row in of_sessions if row.id in used] + list(measured_recordings(session))
    return sorted(
        (row for row in found if row.id not in kept), key=lambda row: (row.opened_at, row.id)
    )


def recordings_in_use(session: Session) -> set[str]:
    """Return the recordings that something is being made from, or what is in force was."""
    _, kept = _calibrated_from(session)
    return kept


def _calibrated_from(session: Session) -> tuple[set[str], set[str]]:
    """Return the recordings of calibrations that are ready; those that one still needs."""
    newest = select(func.max(Activation.id)).group_by(Activation.sensor)
    newest_of_rigs = select(func.max(RigActivation.id)).group_by(RigActivation.rig)
    in_force = {
        *session.scalars(select(Activation.calibration_id).where(Activation.id.in_(newest))),
        *session.scalars(
            select(RigActivation.rig_calibration_id).where(RigActivation.id.in_(newest_of_rigs))
        ),
    }
    used: set[str] = set()
    kept: set[str] = set()
    for calibration_id, state, recordings in _made_from(session):
        if state is CalibrationState.READY:
            used.update(recordings)
        if state is CalibrationState.SOLVING or calibration_id in in_force:
            kept.update(recordings)
    return used, kept | recordings_replayed(session) | recordings_recalibrated(session)


def _made_from(session: Session) -> Iterator[tuple[str, CalibrationState, list[str]]]:
    """Yield all calibrations, of sensors and of rigs: id, state, and recordings."""
    of_sensors = select(Calibration.id, Calibration.state, Calibration.recording_ids)
    of_rigs = select(RigCalibration.id, RigCalibration.state, RigCalibration.ordered)
    for calibration_id, state, recording_ids in session.execute(of_sensors):
        yield calibration_id, state, _flat(recording_ids)
    for calibration_id, state, order in session.execute(of_rigs):
        yield calibration_id, state, _flat({} if order is None else order["recordings"])


def _flat(by_kind: Mapping[str, Sequence[str]]) -> list[str]:
    return [name for names in by_kind.values() for name in names]
