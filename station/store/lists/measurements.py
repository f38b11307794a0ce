"""Measured wheels, in the order they were measured."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from measure import Side
from station.store.lists.paging import Page, page_of
from station.store.tables import AxleWheel, Measurement, ReplayMeasurement


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
