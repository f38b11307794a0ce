"""Having a sensor calibrated anew, and answering what a recalibration asks."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from station.errors import InputUnusable, StateConflict, VersionConflict, VersionMissing
from station.operations.calibrations import closed_recording
from station.operations.collaborators import Station
from station.operations.sensors import sensor_given
from station.recalibration import Outcome
from station.settings import StationSettings
from station.store import (
    RECALIBRATION,
    Action,
    Activation,
    Actor,
    Calibration,
    CalibrationSession,
    Job,
    JobKind,
    Recalibration,
    RecalibrationState,
    SessionState,
    activate,
    active,
    add_job,
    audit,
    recordings_of,
    the,
)
from station.store.recalibrations import (
    asking_recalibrations,
    decided_against,
    recordings_under,
    running_recalibration,
)

_KIND = "recalibration"


@dataclass(frozen=True, slots=True)
class RecalibrationOrder:
    """Which sensor to recalibrate, and from what.

    Attributes
    ----------
    sessions
        Calibration sessions to take; none: those that are new.
    """

    sensor: str
    sessions: Sequence[str] = ()


def order_recalibration(
    station: Station, order: RecalibrationOrder, *, by: Actor
) -> tuple[Recalibration, Job]:
    """Put a recalibration into the worker's list.

    Raises
    ------
    InputUnusable
        If the station has no such sensor, or a session shows nothing of it.
    NotFound
        If the station knows no such session.
    StateConflict
        If the sensor is being recalibrated, or a session is not closed yet.
    """
    sensor_given(station.settings, order.sensor)
    row_id = station.new_id()
    with station.store.change() as session:
        known = session.get(Recalibration, row_id)
        if known is not None:  # ordered by this call, before the API process died of it
            return known, the(session, Job, known.job_id)
        present = running_recalibration(session, order.sensor)
        if present is not None:
            raise StateConflict(
                f"sensor {order.sensor} is being recalibrated, by {present.id}, which is "
                f"{present.state}; follow that one",
                state=present.state,
            )
        row, job = add_recalibration(session, row_id, sensor=order.sensor, by=by, at=station.now())
        if order.sessions:
            row.taken = _named(session, order)
    station.jobs.submit(JobKind.RECALIBRATE, job.id)
    return row, job


def add_recalibration(
    session: Session,
    row_id: str,
    *,
    sensor: str,
    by: Actor,
    at: datetime,
    due_at: datetime | None = None,
) -> tuple[Recalibration, Job]:
    """Add a recalibration and its job; `due_at` is its moment of the schedule."""
    job = add_job(session, f"job-{row_id}", JobKind.RECALIBRATE, row_id, at=at)
    row = Recalibration(
        id=row_id,
        state=RecalibrationState.WAITING,
        sensor=sensor,
        due_at=due_at,
        ordered_at=at,
        ordered_by=by.name,
        job_id=job.id,
        findings={},
        version=1,
    )
    session.add(row)
    told = {"sensor": sensor, "due_at": None if due_at is None else due_at.isoformat()}
    audit(session, Action.ORDER, _KIND, row_id, by=by, at=at, after=told)
    return row, job


def _named(session: Session, order: RecalibrationOrder) -> dict[str, list[str]]:
    recordings = []
    for name in order.sessions:
        shown = the(session, CalibrationSession, name)
        if shown.state is not SessionState.RECORDED:
            raise StateConflict(
                f"calibration session {name} is {shown.state}; finish it, then recalibrate from it",
                state=shown.state,
            )
        own = [each for each in recordings_of(session, shown) if each.sensor == order.sensor]
        if not own:
            raise InputUnusable(
                f"calibration session {name} shows nothing of sensor {order.sensor}; give one of it"
            )
        recordings += [closed_recording(session, each.id, order.sensor) for each in own]
    return {"named": recordings}


def answer_recalibration(
    station: Station, row_id: str, *, bring: bool, why: str, seen: int | None, by: Actor
) -> Recalibration:
    """Answer a recalibration that asks: bring its calibration into force, or refuse it.

    The same answer of the same person a second time changes nothing.

    Parameters
    ----------
    seen
        Version of the recalibration that the person read.

    Raises
    ------
    NotFound
        If there is no such recalibration.
    StateConflict
        If it does not ask, or another calibration came into force since it was compared.
    VersionMissing, VersionConflict
        If the person did not say which version was read, or it has changed since.
    """
    with station.store.change() as session:
        row = the(session, Recalibration, row_id)
        wanted = RecalibrationState.ACTIVATED if bring else RecalibrationState.REFUSED
        if (row.state, row.answered_by, row.answer) == (wanted, by.name, why):
            return row
        RECALIBRATION.check(row.id, row.state, wanted)
        _ensure_seen(row, seen)
        row.answered_by, row.answered_at, row.answer = by.name, station.now(), why
        job = None
        if bring:
            _ensure_still_compared(session, row)
            job = bring_into_force(session, station.settings, row, by=by, at=station.now())
        row.state = wanted
        row.version += 1
        told = {"state": wanted.value, "why": why}
        audit(session, Action.ANSWER, _KIND, row.id, by=by, at=station.now(), after=told)
    if job is not None:
        station.jobs.submit(JobKind.MEASURE_AGAIN, job.id)
    return row


def _ensure_seen(row: Recalibration, seen: int | None) -> None:
    if seen is None:
        raise VersionMissing(
            f"recalibration {row.id} is at version {row.version}; read it and send its ETag in "
            "If-Match"
        )
    if seen != row.version:
        raise VersionConflict(
            f"recalibration {row.id} is at version {row.version}, not {seen}: it changed "
            "meanwhile; read it again and decide anew"
        )


def _ensure_still_compared(session: Session, row: Recalibration) -> None:
    present = active(session, row.sensor)
    version = None if present is None else present.version
    if version != row.present_version:
        raise StateConflict(
            f"another calibration came into force on sensor {row.sensor} since recalibration "
            f"{row.id} was compared with the one before; recalibrate again",
            state=row.state,
        )


def bring_into_force(
    session: Session, settings: StationSettings, row: Recalibration, *, by: Actor, at: datetime
) -> Job | None:
    """Activate the calibration of a recalibration; return the job that measures passes again.

    Raises
    ------
    VersionConflict
        If another calibration came into force since it was compared.
    """
    calibration = the(session, Calibration, row.calibration_id or "")
    present = active(session, row.sensor)
    activation = activate(
        session, calibration, sensor=row.sensor, seen=row.present_version, by=by, at=at
    )
    row.activated_version = activation.version
    wanted = settings.recalibration.policy.measure_again and row.outcome == Outcome.DRIFTED
    if present is None or not wanted:
        return None
    since = last_good_check(session, present)
    if not recordings_under(session, row.sensor, present.calibration_id, since):
        return None
    job = add_job(session, f"again-{row.id}", JobKind.MEASURE_AGAIN, row.id, at=at)
    row.measuring_job_id = job.id
    return job


def last_good_check(session: Session, present: Activation) -> datetime:
    """Return the last moment at which the calibration in force was found good.

    That is when pictures were taken that agree with it; before any, when it came into force.
    """
    good = (
        each.pictures_at or each.ordered_at
        for each in decided_against(session, present.sensor, present.version)
        if each.outcome is not None and Outcome(each.outcome).vouches
    )
    return max(present.activated_at, next(good, present.activated_at))


def supersede_asking(session: Session, row: Recalibration) -> None:
    """End the questions of a sensor's earlier recalibrations: this one knows better."""
    for earlier in asking_recalibrations(session, row.sensor):
        if earlier.id != row.id:
            RECALIBRATION.check(earlier.id, earlier.state, RecalibrationState.SUPERSEDED)
            earlier.state = RecalibrationState.SUPERSEDED
            earlier.version += 1
