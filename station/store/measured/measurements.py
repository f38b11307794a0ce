"""Keeping what was measured: each wheel once per recording, frame, calibration and reference."""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.tables import JsonObject, Measurement, MeasurementProfile, Pass, Recording

_KEY = (
    Measurement.recording_id,
    Measurement.frame,
    Measurement.calibration_id,
    Measurement.rig_calibration_id,
    Measurement.reference,
)
_PROFILE = "profile"
_Key = tuple[str, int, str, str | None, str]


def add_measurements(session: Session, measurements: Sequence[Measurement]) -> int:
    """Add those not yet in the store, leave the others as they are, and return how many are new.

    The profile of a new one goes from its `wheel` into a row of its own: see `profiles_of`.
    """
    there = _there(session, measurements)
    new = [each for each in measurements if _key(each) not in there]
    profiles = [_part_profile(each) for each in new]
    session.add_all(new)
    session.flush()
    session.add_all(
        MeasurementProfile(measurement_id=row.id, profile=profile)
        for row, profile in zip(new, profiles, strict=True)
        if profile is not None
    )
    return len(new)


def same_measurements(session: Session, measurements: Iterable[Measurement]) -> list[int]:
    """Return the ids of those in the store that are of the same wheels, by the same means."""
    wanted = list(measurements)
    there = _there(session, wanted)
    return [there[key] for key in map(_key, wanted) if key in there]


def _there(session: Session, measurements: Iterable[Measurement]) -> dict[_Key, int]:
    """Return the ids of all measurements of the same recordings, by their keys."""
    recordings = sorted({measurement.recording_id for measurement in measurements})
    found = select(*_KEY, Measurement.id).where(Measurement.recording_id.in_(recordings))
    return {
        (recording, frame, calibration, rig, reference): row_id
        for recording, frame, calibration, rig, reference, row_id in session.execute(found)
    }


def _part_profile(row: Measurement) -> JsonObject | None:
    profile: JsonObject | None = row.wheel.get(_PROFILE)
    row.wheel = {name: value for name, value in row.wheel.items() if name != _PROFILE}
    return profile


def profiles_of(session: Session, measurements: Iterable[Measurement]) -> dict[int, JsonObject]:
    """Return the profiles of measured wheels, by the measurement's id."""
    wanted = [measurement.id for measurement in measurements]
    found = select(MeasurementProfile).where(MeasurementProfile.measurement_id.in_(wanted))
    return {row.measurement_id: row.profile for row in session.scalars(found)}


def wheels_of(session: Session, owner: Pass) -> Sequence[Measurement]:
    """Return the wheels of a pass as measured with the calibrations it was recorded under.

    Against the station's reference: a wheel measured once more against another stands behind.
    """
    rig = Measurement.rig_calibration_id
    found = session.scalars(
        select(Measurement)
        .join(Recording, Measurement.recording_id == Recording.id)
        .where(Measurement.pass_id == owner.id)
        .where(Measurement.calibration_id == Recording.calibration_id)
        .where(rig.is_not_distinct_from(Recording.rig_calibration_id))
        .order_by(Measurement.sensor, Measurement.id)
    )
    firsts: dict[tuple[str, int], Measurement] = {}
    for row in found:
        firsts.setdefault((row.recording_id, row.frame), row)
    return list(firsts.values())


def _key(row: Measurement) -> _Key:
    return (
        row.recording_id,
        row.frame,
        row.calibration_id,
        row.rig_calibration_id,
        row.reference,
    )
