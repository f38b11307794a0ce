"""Which measurements a replay came to, and which recordings replays are to measure."""

from collections.abc import Sequence

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from station.store.measured.measurements import same_measurements
from station.store.states import JOB
from station.store.tables import Job, Measurement, Replay, ReplayMeasurement


def note_measured(session: Session, replay_id: str, measurements: Sequence[Measurement]) -> None:
    """Note that a replay came to measurements, which are in the store; again, nothing changes."""
    own = ReplayMeasurement.measurement_id
    known = set(session.scalars(select(own).where(ReplayMeasurement.replay_id == replay_id)))
    session.add_all(
        ReplayMeasurement(replay_id=replay_id, measurement_id=key)
        for key in same_measurements(session, measurements)
        if key not in known
    )


def measured_by(session: Session, replay_id: str) -> int:
    """Return how many measurements a replay has come to."""
    count = select(func.count()).where(ReplayMeasurement.replay_id == replay_id)
    return session.scalar(count) or 0


def recordings_replayed(session: Session) -> set[str]:
    """Return the recordings that replays which have not ended are to measure."""
    steps = session.scalars(
        select(Replay.steps).join(Job, Job.id == Replay.job_id).where(Job.state.in_(JOB.unfinished))
    )
    return {name for each in steps for step in each["steps"] for name in step}
