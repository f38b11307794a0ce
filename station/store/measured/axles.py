"""The axles of passes, and what is known of a wheelset from pass to pass."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from measure import Placing, Side
from station.store.tables import AxleWheel, JsonObject, Measurement, Pass

RECENT = 3
"""Passes that a jump is looked for in: the last is enough where it was measured whole."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """A wheel of a wheelset in one pass: when it went by, and what was measured of it."""

    pass_id: str
    opened_at: datetime
    measurement_id: int
    calibration_id: str
    """Of the sensor; of a wheel that several sensors measured together, that of their rig."""
    reference: str
    wheel: JsonObject


def replace_axles(session: Session, pass_id: str, rows: Iterable[AxleWheel]) -> None:
    """Keep the axles of a pass in place of those kept before; done again, nothing changes."""
    session.execute(delete(AxleWheel).where(AxleWheel.pass_id == pass_id))
    session.add_all(rows)
    session.flush()


def axles_of(session: Session, pass_id: str) -> Sequence[AxleWheel]:
    """Return the wheels of a pass's axles in the order of passing, left before right."""
    return session.scalars(
        select(AxleWheel)
        .where(AxleWheel.pass_id == pass_id)
        .order_by(AxleWheel.place, AxleWheel.side)
    ).all()


def places_of(session: Session, measurements: Iterable[Measurement]) -> dict[int, AxleWheel]:
    """Return the wheels of axles that measurements are of, by the measurement's id."""
    passes = {measurement.id: measurement.pass_id for measurement in measurements}
    own = select(AxleWheel).where(AxleWheel.measurement_id.in_(passes))
    found = {row.measurement_id: row for row in session.scalars(own) if row.measurement_id}
    # Seldom: a wheel that was seen more than once stands beside the surest of its measurements.
    left = {pass_id for key, pass_id in passes.items() if key not in found}
    beside = select(AxleWheel).where(AxleWheel.pass_id.in_(left))
    others = {each: row for row in session.scalars(beside) for each in row.others["measurements"]}
    return others | found


def history_of(
    session: Session,
    wheelset: str,
    *,
    side: Side | None = None,
    before: Pass | None = None,
    most: int = RECENT,
) -> Sequence[Appearance]:
    """Return where a wheelset was measured, the oldest first.

    Parameters
    ----------
    side
        Of the wheelset itself; both where not given.
    before
        A pass: those opened earlier alone.
    most
        How many, the newest ones.

    Returns
    -------
    appearances
        Those whose place in the train is certain: one that is inferred may be another wheelset.
    """
    newest = Pass.opened_at.desc(), AxleWheel.id.desc()
    chosen = (
        select(AxleWheel.id)
        .join(Pass, AxleWheel.pass_id == Pass.id)
        .where(AxleWheel.wheelset == wheelset)
        .where(AxleWheel.placing == Placing.CERTAIN)
        .where(AxleWheel.measurement_id.is_not(None))
        .order_by(*newest)
        .limit(most)
    )
    if side is not None:
        chosen = chosen.where(AxleWheel.wheelset_side == side)
    if before is not None:
        chosen = chosen.where(Pass.opened_at < before.opened_at)
    # Chosen first: sorting all that a wheelset ever was would read every one of its wheels.
    query = (
        select(
            Pass.id,
            Pass.opened_at,
            Measurement.id,
            func.coalesce(Measurement.rig_calibration_id, Measurement.calibration_id),
            Measurement.reference,
            Measurement.wheel,
        )
        .select_from(AxleWheel)
        .join(Pass, AxleWheel.pass_id == Pass.id)
        .join(Measurement, AxleWheel.measurement_id == Measurement.id)
        .where(AxleWheel.id.in_(chosen))
        .order_by(*newest)
    )
    found = [Appearance(*row) for row in session.execute(query)]
    return found[::-1]
