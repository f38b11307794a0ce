"""Finding rows by name, those of one another, and what was measured page by page."""

from collections.abc import Sequence

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from measure import Side
from station.errors import NotFound
from station.store.paging import Page, Row, page_of
from station.store.recalibration_tables import Recalibration
from station.store.replay_tables import Replay, ReplayMeasurement
from station.store.states import SESSION, PassState, SessionState
from station.store.tables import (
    AxleWheel,
    Calibration,
    CalibrationSession,
    Job,
    Measurement,
    Pass,
    Recording,
    RigCalibration,
    Table,
)

_KIND: dict[type[Table], str] = {
    Pass: "pass",
    Recording: "recording",
    CalibrationSession: "calibration session",
    Calibration: "calibration",
    RigCalibration: "calibration of a rig",
    Recalibration: "recalibration",
    Replay: "replay",
    Job: "job",
    Measurement: "measurement",
}


def the(session: Session, table: type[Row], row_id: str | int) -> Row:
    """Return the row of that id.

    Raises
    ------
    NotFound
        If there is none.
    """
    row = session.get(table, row_id)
    if row is None:
        raise NotFound(f"{_KIND[table]} {row_id!r}: the station knows no such one")
    return row


def pass_in_progress(session: Session) -> Pass | None:
    """Return the pass that holds the sensors, if there is one."""
    return session.scalar(
        select(Pass).where(Pass.state.in_([PassState.ARMED, PassState.RECORDING])).limit(1)
    )


def session_in_progress(session: Session, sensor: str) -> CalibrationSession | None:
    """Return the calibration session that holds a sensor, if there is one."""
    return session.scalar(
        select(CalibrationSession)
        .join(Recording, Recording.session_id == CalibrationSession.id)
        .where(Recording.sensor == sensor)
        .where(CalibrationSession.state.in_(SESSION.unfinished))
        .limit(1)
    )


def recordings_of(session: Session, owner: Pass | CalibrationSession) -> Sequence[Recording]:
    """Return the recordings of a pass or a session, ordered by sensor."""
    column = Recording.pass_id if isinstance(owner, Pass) else Recording.session_id
    return session.scalars(
        select(Recording).where(column == owner.id).order_by(Recording.sensor)
    ).all()


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


def open_sessions(session: Session) -> Sequence[CalibrationSession]:
    """Return the calibration sessions not yet finished, oldest first."""
    return session.scalars(
        select(CalibrationSession)
        .where(CalibrationSession.state.in_([SessionState.ARMED, SessionState.OPEN]))
        .order_by(CalibrationSession.opened_at)
    ).all()


def counts_by_state(session: Session, table: type[Pass] | type[Job]) -> dict[str, int]:
    """Return how many passes, or jobs, are in each state."""
    rows = session.execute(select(table.state, func.count()).group_by(table.state))
    return {state.value: count for state, count in rows}


def measurements_page(
    session: Session,
    *,
    limit: int,
    after: int = 0,
    pass_id: str | None = None,
    sensor: str | None = None,
    wheelset: str | None = None,
    side: Side | None = None,
    replay: str | None = None,
) -> Page[Measurement]:
    """Return measurements in the order they were made, from those behind the key `after`.

    `side` is that of the train; with a `wheelset`, its own.  Those of a `replay` are all it came
    to, also what had been measured before.
    """
    of_axle = wheelset is not None or side is not None
    # By the key of the table that an index finds them in: a wheelset's are few among all.
    key = AxleWheel.measurement_id if of_axle else Measurement.id
    query = select(Measurement).where(key > after).order_by(key)
    if pass_id is not None:
        query = query.where(Measurement.pass_id == pass_id)
    if sensor is not None:
        query = query.where(Measurement.sensor == sensor)
    if of_axle:
        query = query.join(AxleWheel, AxleWheel.measurement_id == Measurement.id)
    if wheelset is not None:
        query = query.where(AxleWheel.wheelset == wheelset)
    if side is not None:
        own = AxleWheel.side if wheelset is None else AxleWheel.wheelset_side
        query = query.where(own == side)
    if replay is not None:
        of_replay = select(ReplayMeasurement.measurement_id).where(
            ReplayMeasurement.replay_id == replay
        )
        query = query.where(Measurement.id.in_(of_replay))
    return page_of(session, query, limit)


def frame_totals(session: Session) -> dict[tuple[str, str], int]:
    """Return the frames of all recordings made here, by sensor and by what became of them."""
    fates = ("recorded", "lost", "repeated", "refused")
    columns = [func.coalesce(func.sum(getattr(Recording, fate)), 0) for fate in fates]
    own = select(Recording.sensor, *columns).where(Recording.sha256.is_(None))
    rows = session.execute(own.group_by(Recording.sensor))
    return {
        (row[0], fate): count for row in rows for fate, count in zip(fates, row[1:], strict=True)
    }
