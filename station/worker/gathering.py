"""What of a pass is measured together while it is recorded."""

from collections.abc import Iterable, Sequence

from sqlalchemy.orm import Session

from station.documents import CalibrationDocument, RigDocument
from station.limits import limits_of
from station.pipeline import Looker, Resumption, looking_rig, looking_sensor
from station.settings import MAX_SKEW_US
from station.store import Calibration, Pass, Recording, RigCalibration, recordings_of, the
from station.worker.context import WorkContext
from station.worker.followed import Together
from station.worker.resuming import Means, noted
from station.worker.rows import NO_CALIBRATION, NOT_ARMED


def gathered(context: WorkContext, pass_id: str) -> list[Together]:
    """Return what of a pass is measured together; none without calibrations.

    Raises
    ------
    StationError
        If a calibration, a rig or the reference cannot be used.
    """
    means = Means.of(context)
    with context.store.look() as session:
        recordings = recordings_of(session, the(session, Pass, pass_id))
        return [
            _group(context, session, own, means) for own in _by_looker(recordings) if _measures(own)
        ]


def _by_looker(recordings: Iterable[Recording]) -> list[list[Recording]]:
    """Sort recordings by rig; those of none are each by itself."""
    groups: dict[str, list[Recording]] = {}
    for each in recordings:
        groups.setdefault(each.rig_calibration_id or f"alone:{each.id}", []).append(each)
    return list(groups.values())


def _measures(group: Sequence[Recording]) -> bool:
    return any(each.calibration_id is not None for each in group)


def _group(
    context: WorkContext, session: Session, group: Sequence[Recording], means: Means
) -> Together:
    calibrations = [
        CalibrationDocument.model_validate_json(
            the(session, Calibration, each.calibration_id).document or ""
        )
        for each in group
        if each.calibration_id is not None
    ]
    rig_id = group[0].rig_calibration_id
    if rig_id is None:
        looker = looking_sensor(
            calibrations[0],
            reference=context.settings.reference,
            limits=limits_of(context.settings.limits),
        )
    else:
        document = the(session, RigCalibration, rig_id).document or ""
        looker = _rig(context, RigDocument.model_validate_json(document), group, calibrations)
    taken = {each.sensor: each for each in group if each.sensor in looker.sensors}
    since = noted(session, means, taken.values()) or Resumption({})
    return Together(group[0].pass_id or "", taken, looker, means, since)


def _rig(
    context: WorkContext,
    document: RigDocument,
    group: Sequence[Recording],
    calibrations: Sequence[CalibrationDocument],
) -> Looker:
    settings = context.settings.rig(document.rig)
    armed, calibrated = {each.sensor for each in group}, {each.sensor for each in calibrations}
    return looking_rig(
        document,
        calibrations=[each for each in calibrations if each.sensor in document.names],
        silent_sensors={
            name: NO_CALIBRATION if name in armed else NOT_ARMED
            for name in document.names
            if name not in calibrated
        },
        max_skew_us=MAX_SKEW_US if settings is None else settings.max_skew_us,
        reference=context.settings.reference,
        limits=limits_of(context.settings.limits),
    )
