"""The station's own schedule: what is owed is ordered, also what was due while it was off."""

from datetime import datetime

import structlog
from sqlalchemy.orm import Session

from station.operations import add_recalibration
from station.recalibration import Schedule, owed
from station.store import Actor, Recalibration, active
from station.store.recalibrations import running_recalibration, settled_until
from station.worker.context import WorkContext

_log = structlog.get_logger()
_BY = Actor("schedule")


def order_what_is_owed(context: WorkContext) -> list[Recalibration]:
    """Order the recalibrations that are due, one of each sensor at most; return them.

    A sensor without a calibration in force owes none: its first one is ordered by a person.
    """
    schedule = Schedule.from_settings(context.settings.recalibration)
    if schedule is None:
        return []
    ordered = [_order(context, schedule, sensor.id) for sensor in context.settings.sensors]
    return [row for row in ordered if row is not None]


def _order(context: WorkContext, schedule: Schedule, sensor: str) -> Recalibration | None:
    now = context.now()
    # Only looked at, as a rule: a second of the worker's is not to cost a transaction of the disk.
    with context.store.look() as session:
        if _owed(session, schedule, sensor, now) is None:
            return None
    with context.store.change() as session:
        due = _owed(session, schedule, sensor, now)
        if due is None:
            return None
        name = f"{sensor}.{due:%Y%m%dT%H%M%SZ}"
        row, _ = add_recalibration(session, name, sensor=sensor, by=_BY, at=now, due_at=due)
    late_s = (now - due).total_seconds()
    _log.info("recalibration due", sensor=sensor, recalibration=name, late_s=round(late_s))
    return row


def _owed(session: Session, schedule: Schedule, sensor: str, now: datetime) -> datetime | None:
    present = active(session, sensor)
    if present is None or running_recalibration(session, sensor) is not None:
        return None
    settled = settled_until(session, sensor) or present.activated_at
    return owed(schedule, since=max(settled, present.activated_at), now=now)
