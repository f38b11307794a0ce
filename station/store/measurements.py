"""Keeping what was measured: each wheel once per recording, frame and calibration."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.tables import Measurement


def add_measurements(session: Session, measurements: Sequence[Measurement]) -> int:
    """Add those not yet in the store, leave the others as they are, and return how many are new."""
    if not measurements:
        return 0
    first = measurements[0]
    there = set(
        session.scalars(
            select(Measurement.frame)
            .where(Measurement.recording_id == first.recording_id)
            .where(Measurement.calibration_id == first.calibration_id)
        )
    )
    new = [measurement for measurement in measurements if measurement.frame not in there]
    session.add_all(new)
    return len(new)
