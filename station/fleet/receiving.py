"""What the fleet's database takes from a station: all of a batch with its mark, or nothing."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, func, insert, select, type_coerce, update
from sqlalchemy.orm import Session, aliased

from station.errors import StationError
from station.fleet.packing import Packed
from station.fleet.tables import (
    FleetAlarm,
    FleetAxle,
    FleetCalibration,
    FleetEpoch,
    FleetPass,
    FleetRecalibration,
    FleetRefusal,
    FleetStation,
    FleetWheel,
    OfEpoch,
)
from station.store import JsonObject, UtcDateTime
from station.store.changes import ChangesLeft


class MarkMoved(StationError):
    """Somebody else sends for this station's store too; ask for the mark again."""


@dataclass(frozen=True, slots=True)
class Sender:
    """Who sends: the station, which life of its store, and the limits it judges by."""

    station: str
    name: str
    software: str
    store_epoch: str
    limits: JsonObject


@dataclass(frozen=True, slots=True)
class Mark:
    """How far a station's store has told.

    Attributes
    ----------
    epoch
        The fleet's number of the store's life.
    number, token
        Of the last change that is here, and of the batch it came with: None before the first.
    """

    epoch: int
    number: int
    token: str | None


@dataclass(frozen=True, slots=True)
class Batch:
    """Some changes, and what is left after them."""

    packed: Sequence[Packed]
    number: int
    token: str
    left: ChangesLeft


def hear(session: Session, sender: Sender, left: ChangesLeft | None, at: datetime) -> Mark:
    """Note that a station is there, and return how far its store has told.

    Parameters
    ----------
    left
        What it has not sent; None where it does not know yet.
    at
        By the station's clock.
    """
    now = fleet_now(session)
    _note_station(session, sender, left, at, now)
    found = session.scalar(
        select(FleetEpoch)
        .where(FleetEpoch.station == sender.station)
        .where(FleetEpoch.store_epoch == sender.store_epoch)
        .with_for_update()
    )
    if found is None:
        found = _begin(session, sender, now)
    found.heard_at = now
    session.flush()
    return Mark(found.epoch, found.number, found.token)


def take(session: Session, sender: Sender, mark: Mark, batch: Batch, at: datetime) -> Mark:
    """Take a batch in: what was known of the same things makes way, and the mark moves on.

    Raises
    ------
    MarkMoved
        If the mark is not where the station saw it.
    """
    _ensure_mark(session, sender, mark, batch, at)
    for packed in batch.packed:
        _replace(session, sender.station, mark.epoch, packed)
        _forget_refusal(session, sender.station, mark.epoch, packed)
    return _moved(mark, batch)


def refuse(
    session: Session, sender: Sender, mark: Mark, batch: Batch, why: str, at: datetime
) -> Mark:
    """Pass over a batch of one that the database does not take, and keep that it did.

    Raises
    ------
    MarkMoved
        If the mark is not where the station saw it.
    """
    _ensure_mark(session, sender, mark, batch, at)
    for packed in batch.packed:
        _forget_refusal(session, sender.station, mark.epoch, packed)
        session.add(
            FleetRefusal(
                station=sender.station,
                epoch=mark.epoch,
                kind=packed.kind.value,
                key=packed.key,
                number=packed.number,
                why=why,
                refused_at=fleet_now(session),
            )
        )
    return _moved(mark, batch)


def _moved(mark: Mark, batch: Batch) -> Mark:
    return Mark(mark.epoch, batch.number, batch.token)


def fleet_now(session: Session) -> datetime:
    """Return the moment by the clock of the database; a station's own may be wrong."""
    on_sqlite = session.get_bind().dialect.name == "sqlite"
    clock = func.strftime("%Y-%m-%d %H:%M:%f", "now") if on_sqlite else func.clock_timestamp()
    return session.scalars(select(type_coerce(clock, UtcDateTime()))).one()


def _note_station(
    session: Session, sender: Sender, left: ChangesLeft | None, at: datetime, now: datetime
) -> None:
    row = session.get(FleetStation, sender.station, with_for_update=True)
    if row is None:
        row = FleetStation(id=sender.station, first_heard_at=now, unsent=0)
        session.add(row)
    row.name, row.software, row.last_heard_at = sender.name, sender.software, now
    row.limits = sender.limits
    row.clock_ahead_s = (at - now).total_seconds()
    if left is not None:
        row.unsent, row.unsent_since = left.count, left.since
    session.flush()


def _begin(session: Session, sender: Sender, now: datetime) -> FleetEpoch:
    of_station = FleetEpoch.station == sender.station
    last = session.scalar(select(func.max(FleetEpoch.epoch)).where(of_station)) or 0
    row = FleetEpoch(
        station=sender.station,
        epoch=last + 1,
        store_epoch=sender.store_epoch,
        began_at=now,
        number=0,
    )
    session.add(row)
    return row


def _ensure_mark(session: Session, sender: Sender, mark: Mark, batch: Batch, at: datetime) -> None:
    """Move the mark on, if it is where the station saw it; the rows follow in its transaction."""
    now = fleet_now(session)
    _note_station(session, sender, batch.left, at, now)  # first, as in `hear`: locks in one order
    moved = session.execute(
        update(FleetEpoch)
        .where(FleetEpoch.station == sender.station)
        .where(FleetEpoch.epoch == mark.epoch)
        .where(FleetEpoch.number == mark.number)
        .where(FleetEpoch.token.is_not_distinct_from(mark.token))
        .values(number=batch.number, token=batch.token, heard_at=now)
        .returning(FleetEpoch.epoch)
    ).first()
    if moved is None:
        raise MarkMoved(
            f"station {sender.station!r}: its mark in the fleet is no longer at {mark.number}; "
            "does another station send under the same name?"
        )


_PARTS: dict[type[OfEpoch], tuple[type[OfEpoch], ...]] = {
    FleetPass: (FleetAlarm, FleetAxle, FleetWheel)
}
"""What goes with a thing, those that refer to it first."""
_KEYS: dict[type[OfEpoch], tuple[str, ...]] = {
    FleetPass: ("id",),
    FleetCalibration: ("of", "name", "version"),
    FleetRecalibration: ("id",),
}
_SAME: dict[type[OfEpoch], tuple[str, ...]] = {
    FleetPass: ("id", "opened_at"),
    FleetCalibration: ("of", "name", "calibration_id", "activated_at"),
    FleetRecalibration: ("id", "ordered_at"),
}
"""By what a thing of one epoch is known in another: its key alone may name another thing there."""


def _replace(session: Session, station: str, epoch: int, packed: Packed) -> None:
    if not packed.rows:
        return
    own = {"station": station, "epoch": epoch}
    table, *_ = packed.rows
    (thing,) = packed.rows[table]
    for part in _PARTS.get(table, ()):
        session.execute(delete(part).filter_by(**own, pass_id=thing["id"]))
    session.execute(delete(table).filter_by(**own, **{n: thing[n] for n in _KEYS[table]}))
    for part, rows in packed.rows.items():
        if rows:
            session.execute(insert(part), [{**own, **row} for row in rows])
    _supersede(session, station, table, {name: thing[name] for name in _SAME[table]})


def _supersede(
    session: Session, station: str, table: type[OfEpoch], same: dict[str, object]
) -> None:
    """Let the latest epoch speak for a thing that several tell of."""
    any_epoch = aliased(table)
    latest = select(func.max(any_epoch.epoch)).filter_by(station=station, **same).scalar_subquery()
    session.execute(
        update(table)
        .filter_by(station=station, **same)
        .values(superseded=table.epoch < latest)
        .execution_options(synchronize_session=False)
    )


def _forget_refusal(session: Session, station: str, epoch: int, packed: Packed) -> None:
    session.execute(
        delete(FleetRefusal).filter_by(
            station=station, epoch=epoch, kind=packed.kind.value, key=packed.key
        )
    )
