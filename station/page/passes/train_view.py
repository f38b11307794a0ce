"""A train as a row of axles, left and right."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from measure import Placing, Quantity, Side
from station.documents import BackToBackDocument, ReadingDocument
from station.operations import PassView, PassWheels
from station.page.passes.list_view import STATE_KIND
from station.page.passes.marks import Mark, mark_of
from station.store import PASS, Job, JsonObject, Measurement, Pass, PassState, Recording
from station.store.lists import jobs_page
from station.trains import (
    AlarmKind,
    AxleAlarm,
    AxlePicture,
    TrainPicture,
    VehicleSpread,
    WheelPicture,
)

_JOBS = 20
Readings = Mapping[Quantity, ReadingDocument]


@dataclass(frozen=True, slots=True)
class WheelView:
    """One wheel of an axle."""

    measurement: int | None
    others: tuple[int, ...]
    """Further measurements of the same wheel."""
    side: Side
    mark: Mark
    readings: Readings
    """Of those quantities that have a value."""
    reason: str | None
    """Why it was not seen, or not measured."""


@dataclass(frozen=True, slots=True)
class AxleView:
    """One axle of a train."""

    place: int
    number: int | None
    placing: Placing
    remark: str | None
    passed_at: datetime | None
    wheelset: str | None
    vehicle: str | None
    first_of_vehicle: bool
    position: str | None
    back_to_back: BackToBackDocument | None
    wheels: tuple[WheelView, WheelView]
    """Left and right."""


@dataclass(frozen=True, slots=True)
class AlarmLine:
    """One thing that somebody is to look at, with the wheel that it is on."""

    alarm: AxleAlarm
    measurement: int | None
    """None of a whole axle."""
    jump: JsonObject | None
    """What it jumped from, where it did."""


@dataclass(frozen=True, slots=True)
class MeasuredSoFar:
    """A wheel whose axle is not yet known."""

    measurement: int
    sensor: str
    frame: int
    mark: Mark


@dataclass(frozen=True, slots=True)
class TrainView:
    """A pass, all that is known of it now."""

    row: Pass
    kind: str
    """Of the state's badge."""
    goes_on: bool
    """Whether it is still to change by itself."""
    recordings: Sequence[Recording]
    jobs: Sequence[Job]
    counted: int | None
    remarks: tuple[str, ...]
    axles: tuple[AxleView, ...]
    so_far: tuple[MeasuredSoFar, ...]
    """Wheels measured while the axles are not yet known."""
    alarms: tuple[AlarmLine, ...]
    vehicles: tuple[VehicleSpread, ...]


def train_view(session: Session, view: PassView, found: PassWheels) -> TrainView:
    """Return what is shown of a pass."""
    measured = {wheel.id: wheel for wheel in found.wheels}
    picture, row = found.train, found.row
    axles = _axles(picture, measured)
    return TrainView(
        row=row,
        kind=STATE_KIND[row.state],
        goes_on=not PASS.ended(row.state) and row.state is not PassState.FAILED,
        recordings=view.recordings,
        jobs=jobs_page(session, limit=_JOBS, subject=row.id).rows,
        counted=picture.counted,
        remarks=tuple(
            each
            for each in (row.ended_why, row.reason, picture.remark, picture.no_back_to_back)
            if each
        ),
        axles=axles,
        so_far=() if axles else tuple(_so_far(wheel) for wheel in found.wheels),
        alarms=tuple(_alarm_line(alarm, picture) for alarm in picture.alarms),
        vehicles=picture.vehicles,
    )


def _alarm_line(alarm: AxleAlarm, picture: TrainPicture) -> AlarmLine:
    if alarm.side is None:
        return AlarmLine(alarm, None, None)
    axle = next(each for each in picture.axles if each.place == alarm.place)
    wheel = axle.left if alarm.side is Side.LEFT else axle.right
    jump = wheel.jumps.get(alarm.quantity) if alarm.kind is AlarmKind.JUMP else None
    return AlarmLine(alarm, wheel.measurement, jump)


def _axles(picture: TrainPicture, measured: Mapping[int, Measurement]) -> tuple[AxleView, ...]:
    raised: dict[tuple[int, Side | None], list[AxleAlarm]] = {}
    for alarm in picture.alarms:
        raised.setdefault((alarm.place, alarm.side), []).append(alarm)
    before: str | None = None
    axles = []
    for axle in picture.axles:
        left, right = (
            _wheel(side, wheel, measured, raised.get((axle.place, side), ()))
            for side, wheel in ((Side.LEFT, axle.left), (Side.RIGHT, axle.right))
        )
        first = axle.vehicle is not None and axle.vehicle != before
        axles.append(_axle(axle, (left, right), first_of_vehicle=first))
        before = axle.vehicle
    return tuple(axles)


def _axle(
    axle: AxlePicture,
    wheels: tuple[WheelView, WheelView],
    *,
    first_of_vehicle: bool,
) -> AxleView:
    between = axle.back_to_back
    return AxleView(
        place=axle.place,
        number=axle.number,
        placing=axle.placing,
        remark=axle.remark,
        passed_at=axle.passed_at,
        wheelset=axle.wheelset,
        vehicle=axle.vehicle,
        first_of_vehicle=first_of_vehicle,
        position=axle.position,
        back_to_back=None if between is None else BackToBackDocument.model_validate(between),
        wheels=wheels,
    )


def _wheel(
    side: Side,
    wheel: WheelPicture,
    measured: Mapping[int, Measurement],
    raised: Sequence[AxleAlarm],
) -> WheelView:
    found = None if wheel.measurement is None else measured.get(wheel.measurement)
    return WheelView(
        measurement=wheel.measurement,
        others=wheel.others,
        side=side,
        mark=mark_of(
            seen=found is not None,
            measured=found is not None and found.wheel.get("reason") is None,
            levels=[alarm.level for alarm in raised],
        ),
        readings={} if found is None else readings_in(found),
        reason=wheel.reason,
    )


def _so_far(found: Measurement) -> MeasuredSoFar:
    levels = {reading.alarm for reading in readings_in(found).values()}
    measured = found.wheel.get("reason") is None
    return MeasuredSoFar(
        measurement=found.id,
        sensor=found.sensor,
        frame=found.frame,
        mark=mark_of(seen=True, measured=measured, levels=levels),
    )


def readings_in(row: Measurement) -> Readings:
    """Return the quantities of a measured wheel that have a value."""
    found = {quantity: row.wheel.get(quantity.value) for quantity in Quantity}
    return {
        quantity: ReadingDocument.model_validate(kept)
        for quantity, kept in found.items()
        if kept is not None and kept["value"] is not None
    }
