"""A train as its readings show it: axle for axle, what differs, and what raises an alarm."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import groupby

from sqlalchemy.orm import Session

from measure import (
    COMPARED,
    Difference,
    Placing,
    Quantity,
    Reading,
    Side,
    Status,
    difference,
    spread,
)
from station.back_to_back import NO_TRACK
from station.store import AxleWheel, JsonObject, Measurement, Pass
from station.store.measured import axles_of
from station.trains.alarms import AxleAlarm, axle_alarms, name_of, wheel_alarms
from station.trains.consist import Consist
from station.trains.wheels import readings_of


@dataclass(frozen=True, slots=True)
class QuantityDifference:
    """Left less right, mm."""

    value: float
    u95: float
    status: Status

    @classmethod
    def of(cls, found: Difference) -> "QuantityDifference":
        """Take over what `measure` found."""
        return cls(found.value_mm, found.u95_mm, found.status)


@dataclass(frozen=True, slots=True)
class WheelPicture:
    """One wheel of an axle: which measurement it is, or why it was not seen."""

    measurement: int | None
    others: tuple[int, ...]
    reason: str | None
    """Why it was not seen, or seen but not measured."""
    wheelset_side: Side | None
    jumps: JsonObject


@dataclass(frozen=True, slots=True)
class AxlePicture:
    """One axle of a train."""

    place: int
    number: int | None
    placing: Placing
    remark: str | None
    passed_at: datetime | None
    wheelset: str | None
    vehicle: str | None
    position: str | None
    left: WheelPicture
    right: WheelPicture
    differences: Mapping[Quantity, QuantityDifference]
    """Left less right, where both were measured."""
    back_to_back: JsonObject | None
    """A `BackToBackDocument`; None where no track was known when the pass was measured."""


@dataclass(frozen=True, slots=True)
class VehicleSpread:
    """The greatest difference between the wheels of a vehicle, and which they are."""

    vehicle: str
    quantity: Quantity
    value: float
    u95: float
    status: Status
    greatest: str
    smallest: str


@dataclass(frozen=True, slots=True)
class TrainPicture:
    """A train, axle for axle in the order of passing."""

    counted: int | None
    remark: str | None
    no_back_to_back: str | None = None
    """Why no axle has a back-to-back distance though both sides were measured."""
    axles: tuple[AxlePicture, ...] = ()
    vehicles: tuple[VehicleSpread, ...] = ()
    alarms: tuple[AxleAlarm, ...] = ()


@dataclass(frozen=True, slots=True)
class _Wheel:
    row: AxleWheel
    measurement: Measurement | None
    readings: Mapping[Quantity, Reading] = field(default_factory=dict)


def train_picture(session: Session, row: Pass, found: Sequence[Measurement]) -> TrainPicture:
    """Return the train of a pass with these measured wheels; no axles before the measuring ends."""
    measured = {wheel.id: wheel for wheel in found}
    wheels = [_wheel(each, measured) for each in axles_of(session, row.id)]
    consist = None if row.consist is None else Consist.from_json(row.consist)
    return TrainPicture(
        counted=row.axles,
        remark=None if consist is None else consist.misfit(row.axles),
        no_back_to_back=_no_back_to_back(wheels),
        axles=tuple(_axle(list(pair)) for _, pair in groupby(wheels, key=_place)),
        vehicles=tuple(_vehicles(wheels)),
        alarms=tuple(alarm for wheel in wheels for alarm in _alarms(wheel)),
    )


def _no_back_to_back(wheels: Sequence[_Wheel]) -> str | None:
    sides = {wheel.row.side for wheel in wheels if wheel.measurement is not None}
    known = any(wheel.row.back_to_back is not None for wheel in wheels)
    return None if known or len(sides) < len(Side) else NO_TRACK


def _place(wheel: _Wheel) -> int:
    return wheel.row.place


def _wheel(row: AxleWheel, measured: Mapping[int, Measurement]) -> _Wheel:
    found = None if row.measurement_id is None else measured.get(row.measurement_id)
    return _Wheel(row, found) if found is None else _Wheel(row, found, readings_of(found))


def _axle(pair: Sequence[_Wheel]) -> AxlePicture:
    left, right = sorted(pair, key=lambda wheel: wheel.row.side)
    row = left.row
    found = {
        quantity: difference(left.readings[quantity], right.readings[quantity])
        for quantity in COMPARED
        if left.readings and right.readings
    }
    return AxlePicture(
        place=row.place,
        number=row.number,
        placing=row.placing,
        remark=row.remark,
        passed_at=row.passed_at,
        wheelset=row.wheelset,
        vehicle=row.vehicle,
        position=row.position,
        left=_wheel_picture(left),
        right=_wheel_picture(right),
        differences={
            quantity: QuantityDifference.of(one) for quantity, one in found.items() if one
        },
        back_to_back=row.back_to_back,
    )


def _wheel_picture(wheel: _Wheel) -> WheelPicture:
    unmeasured = None if wheel.measurement is None else wheel.measurement.wheel.get("reason")
    return WheelPicture(
        measurement=wheel.row.measurement_id,
        others=tuple(wheel.row.others["measurements"]),
        reason=wheel.row.reason or unmeasured,
        wheelset_side=wheel.row.wheelset_side,
        jumps=wheel.row.jumps,
    )


def _vehicles(wheels: Sequence[_Wheel]) -> Iterable[VehicleSpread]:
    """Yield how far the wheels of each vehicle differ, where the consist names vehicles."""
    vehicles: dict[str, list[_Wheel]] = {}
    for wheel in wheels:
        if wheel.row.vehicle is not None and wheel.readings:
            vehicles.setdefault(wheel.row.vehicle, []).append(wheel)
    for vehicle, own in vehicles.items():
        for quantity in COMPARED:
            found = spread([wheel.readings[quantity] for wheel in own])
            if found is not None:
                yield VehicleSpread(
                    vehicle=vehicle,
                    quantity=quantity,
                    value=found.difference.value_mm,
                    u95=found.difference.u95_mm,
                    status=found.difference.status,
                    greatest=name_of(own[found.greatest].row),
                    smallest=name_of(own[found.smallest].row),
                )


def _alarms(wheel: _Wheel) -> Iterable[AxleAlarm]:
    regime = None if wheel.measurement is None else wheel.measurement.regime
    if wheel.row.side is Side.LEFT:
        yield from axle_alarms(wheel.row, regime)
    yield from wheel_alarms(wheel.row, wheel.readings, regime)
