"""Looking up what tells how the station is: few rows each, by an index, as it is asked often."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import func, select, text
from sqlalchemy.orm import Session

from station.store.states import JobState, PassState
from station.store.tables import Job, JsonObject, Measurement, Pass, Recalibration, Recording


def last_pass_recording(session: Session, sensor: str) -> tuple[Recording, Pass] | None:
    """Return what a sensor recorded of the last pass that was closed, and the pass."""
    found = session.execute(
        select(Recording, Pass)
        .join(Pass, Recording.pass_id == Pass.id)
        .where(Recording.sensor == sensor)
        .where(Recording.closed_at.is_not(None))
        .order_by(Recording.opened_at.desc(), Recording.id.desc())
        .limit(1)
    ).first()
    return None if found is None else (found[0], found[1])


def last_recalibration(session: Session, sensor: str) -> Recalibration | None:
    """Return the recalibration of a sensor that was ordered last, whatever came of it."""
    return session.scalar(
        select(Recalibration)
        .where(Recalibration.sensor == sensor)
        .order_by(Recalibration.ordered_at.desc(), Recalibration.id.desc())
        .limit(1)
    )


def queued_jobs(session: Session) -> dict[str, tuple[int, datetime]]:
    """Return how many jobs of a kind wait for the worker, and since when the oldest does."""
    rows = session.execute(
        select(Job.kind, func.count(), func.min(Job.created_at))
        .where(Job.state == JobState.QUEUED)
        .group_by(Job.kind)
    )
    return {kind: (count, oldest) for kind, count, oldest in rows}


def counts_by_state(session: Session, table: type[Pass] | type[Job]) -> dict[str, int]:
    """Return how many passes, or jobs, are in each state."""
    rows = session.execute(select(table.state, func.count()).group_by(table.state))
    return {state.value: count for state, count in rows}


def frame_totals(session: Session) -> dict[tuple[str, str], int]:
    """Return the frames of all recordings made here, by sensor and by what became of them."""
    fates = ("recorded", "lost", "repeated", "refused")
    columns = [func.coalesce(func.sum(getattr(Recording, fate)), 0) for fate in fates]
    own = select(Recording.sensor, *columns).where(Recording.sha256.is_(None))
    rows = session.execute(own.group_by(Recording.sensor))
    return {
        (row[0], fate): count for row in rows for fate, count in zip(fates, row[1:], strict=True)
    }


@dataclass(frozen=True, slots=True)
class MeasuredPass:
    """A pass that was measured, and how long that took."""

    finished_at: datetime
    started_at: datetime
    ended_at: datetime
    wheels: int


def measured_since(session: Session, since: datetime) -> Sequence[MeasuredPass]:
    """Return the passes whose measuring ended after a moment, the first one first."""
    wheels = (
        select(func.count()).where(Measurement.pass_id == Pass.id).correlate(Pass).scalar_subquery()
    )
    rows = session.execute(
        select(Pass.finished_at, Job.started_at, Job.ended_at, wheels)
        .join(Pass, Pass.job_id == Job.id)
        .where(Job.ended_at > since)
        .where(Job.state == JobState.DONE)
        .where(Pass.state.in_([PassState.DONE, PassState.RECOVERED]))
        .order_by(Job.ended_at)
    )
    return [MeasuredPass(*row) for row in rows if None not in row]


def last_measured_pass(session: Session) -> str | None:
    """Return the pass whose wheels were measured last."""
    return session.scalar(
        select(Measurement.pass_id)
        .where(Measurement.pass_id.is_not(None))
        .order_by(Measurement.id.desc())
        .limit(1)
    )


@dataclass(frozen=True, slots=True)
class WheelsSeen:
    """What came of the wheels of a pass."""

    measured: int
    unmeasurable: int
    coverage: float | None
    """How much of the profile was seen, mean of the measured; None without any."""


def wheels_seen(session: Session, pass_id: str) -> Mapping[str, WheelsSeen]:
    """Return what came of the wheels of a pass, by the sensor, or the rig, that saw them."""
    rows = session.execute(
        select(Measurement.sensor, Measurement.wheel).where(Measurement.pass_id == pass_id)
    )
    wheels: dict[str, list[JsonObject]] = {}
    for sensor, wheel in rows:
        wheels.setdefault(sensor, []).append(wheel)
    return {sensor: _seen(each) for sensor, each in wheels.items()}


def _seen(wheels: Sequence[JsonObject]) -> WheelsSeen:
    measured = [wheel for wheel in wheels if wheel.get("reason") is None]
    told = [wheel.get("quality", {}).get("coverage") for wheel in measured]
    covered = [float(each) for each in told if each is not None]
    return WheelsSeen(
        measured=len(measured),
        unmeasurable=len(wheels) - len(measured),
        coverage=sum(covered) / len(covered) if covered else None,
    )


def has_frames(session: Session, sensor: str) -> bool:
    """Tell whether there is a closed recording of a sensor, made here, that has frames."""
    query = (
        select(Recording.id)
        .where(Recording.sensor == sensor)
        .where(Recording.sha256.is_(None))
        .where(Recording.deleted_at.is_(None))
        .where(Recording.recorded > 0)
        .limit(1)
    )
    return session.scalar(query) is not None


def frames_kept_since(session: Session, since: datetime) -> Mapping[str, int]:
    """Return how many frames each sensor recorded of what was opened since a moment and is kept."""
    rows = session.execute(
        select(Recording.sensor, func.sum(Recording.recorded))
        .where(Recording.opened_at >= since)
        .where(Recording.deleted_at.is_(None))
        .group_by(Recording.sensor)
    )
    return {sensor: frames or 0 for sensor, frames in rows}


def database_bytes(session: Session) -> int | None:
    """Return the size of a database in PostgreSQL; None of a file, which has its own."""
    if session.get_bind().dialect.name != "postgresql":
        return None
    size = session.scalar(text("SELECT pg_database_size(current_database())"))
    return None if size is None else int(size)
