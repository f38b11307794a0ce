"""Keeping what was measured: each wheel once per recording, frame and calibration."""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.tables import JsonObject, Measurement, MeasurementProfile

_KEY = (
    Measurement.recording_id,
    Measurement.frame,
    Measurement.calibration_id,
    Measurement.rig_calibration_id,
)
_PROFILE = "profile"


def add_measurements(session: Session, measurements: Sequence[Measurement]) -> int:
    """Add those not yet in the store, leave the others as they are, and return how many are new.

    The profile of a new one goes from its `wheel` into a row of its own: see `profiles_of`.
    """
    recordings = {measurement.recording_id for measurement in measurements}
    there = {
        tuple(row)
        for row in session.execute(
            select(*_KEY).where(Measurement.recording_id.in_(sorted(recordings)))
        )
    }
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


def _part_profile(row: Measurement) -> JsonObject | None:
    profile: JsonObject | None = row.wheel.get(_PROFILE)
    row.wheel = {name: value for name, value in row.wheel.items() if name != _PROFILE}
    return profile


def profiles_of(session: Session, measurements: Iterable[Measurement]) -> dict[int, JsonObject]:
    """Return the profiles of measured wheels, by the measurement's id."""
    wanted = [measurement.id for measurement in measurements]
    found = select(MeasurementProfile).where(MeasurementProfile.measurement_id.in_(wanted))
    return {row.measurement_id: row.profile for row in session.scalars(found)}


def _key(row: Measurement) -> tuple[str, int, str, str | None]:
    return row.recording_id, row.frame, row.calibration_id, row.rig_calibration_id
