"""One wheel as measured: its readings and their limits, by what, from what, and how well."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from measure import Alarm, Limit, Limits, Quantity, Side
from station.documents import BackToBackDocument, ReadingDocument, WheelDocument
from station.page.passes.marks import Mark, mark_of
from station.store import AxleWheel, JsonObject, Measurement, Pass, Recording, the
from station.store.measured import axles_of, places_of, profiles_of


@dataclass(frozen=True, slots=True)
class ReadingRow:
    """One quantity with what it may be."""

    quantity: Quantity
    reading: ReadingDocument
    limit: Limit | None
    jump: JsonObject | None
    """Its change since the wheelset's pass before, where that is an alarm."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """The wheels that a person goes on to."""

    before: int | None
    after: int | None
    opposite: int | None
    """On the same axle."""
    others: tuple[int, ...]
    """Further measurements of this very wheel, by other calibrations or from other frames."""


@dataclass(frozen=True, slots=True)
class OneWheel:
    """A measured wheel, and what stands around it."""

    row: Measurement
    train: Pass | None
    """None of a recording that belongs to no pass."""
    place: AxleWheel | None
    side: Side | None
    mark: Mark
    readings: tuple[ReadingRow, ...]
    back_to_back: BackToBackDocument | None
    back_to_back_limit: Limit | None
    reason: str | None
    sensors: tuple[str, ...]
    """Those whose points are in the readings."""
    frames: tuple[int, ...]
    quality: Mapping[str, object]
    has_profile: bool
    recording: Recording
    neighbours: Neighbours
    regime_now: str
    """Whose limits are shown; those that it was judged by may have been others."""


def one_wheel(session: Session, measurement_id: int, limits: Limits) -> OneWheel:
    """Return a measured wheel.

    Raises
    ------
    NotFound
        If the station knows no such measurement.
    """
    row = the(session, Measurement, measurement_id)
    place = places_of(session, [row]).get(row.id)
    wheel = WheelDocument.model_validate(row.wheel)
    between = None if place is None else place.back_to_back
    rows = tuple(_reading(quantity, wheel, place, limits) for quantity in Quantity)
    return OneWheel(
        row=row,
        train=None if row.pass_id is None else the(session, Pass, row.pass_id),
        place=place,
        side=wheel.side if place is None else place.side,
        mark=_mark(wheel, rows),
        readings=rows,
        back_to_back=None if between is None else BackToBackDocument.model_validate(between),
        back_to_back_limit=limits.back_to_back,
        reason=wheel.reason,
        sensors=wheel.sensors or (wheel.sensor,),
        frames=wheel.frames,
        quality=wheel.quality,
        has_profile=bool(profiles_of(session, [row])),
        recording=the(session, Recording, row.recording_id),
        neighbours=_neighbours(session, row, place),
        regime_now=limits.regime,
    )


def _reading(
    quantity: Quantity, wheel: WheelDocument, place: AxleWheel | None, limits: Limits
) -> ReadingRow:
    jumps = {} if place is None else place.jumps
    return ReadingRow(
        quantity, wheel.readings[quantity], limits.of.get(quantity), jumps.get(quantity.value)
    )


def _mark(wheel: WheelDocument, rows: Sequence[ReadingRow]) -> Mark:
    levels = {row.reading.alarm for row in rows}
    if any(row.jump is not None for row in rows):
        levels.add(Alarm.ALARM)
    return mark_of(seen=True, measured=wheel.reason is None, levels=levels)


def _neighbours(session: Session, row: Measurement, place: AxleWheel | None) -> Neighbours:
    if place is None:
        return Neighbours(None, None, None, ())
    seen = {
        (each.place, each.side): each.measurement_id for each in axles_of(session, place.pass_id)
    }
    same = {place.measurement_id, *place.others["measurements"]} - {row.id, None}
    opposite = Side.RIGHT if place.side is Side.LEFT else Side.LEFT
    return Neighbours(
        before=seen.get((place.place - 1, place.side)),
        after=seen.get((place.place + 1, place.side)),
        opposite=seen.get((place.place, opposite)),
        others=tuple(sorted(same)),
    )
