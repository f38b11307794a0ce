"""Finding rows by their ids, and those of one another."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.errors import NotFound
from station.store.tables import (
    Calibration,
    CalibrationSession,
    Job,
    Measurement,
    Pass,
    Recalibration,
    Recording,
    Replay,
    RigCalibration,
    Table,
)
from station.store.tables.base import Row

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


def recordings_of(session: Session, owner: Pass | CalibrationSession) -> Sequence[Recording]:
    """Return the recordings of a pass or a session, ordered by sensor."""
    column = Recording.pass_id if isinstance(owner, Pass) else Recording.session_id
    return session.scalars(
        select(Recording).where(column == owner.id).order_by(Recording.sensor)
    ).all()
