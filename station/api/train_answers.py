"""What comes out over HTTP of trains: axles, alarms, and how wheelsets change."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict

from measure import Alarm, Placing, Quantity, Side, Status
from station.trains import AlarmKind


class _Out(BaseModel):
    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True, from_attributes=True)


class JumpModel(_Out):
    """A change of a wheel since its wheelset's pass before, mm."""

    change: float
    u95: float
    limit: float
    before: str
    """The pass it is compared with."""


class AxleWheelModel(_Out):
    """One wheel of an axle: which measurement it is, or why it was not seen."""

    measurement: int | None
    """`id` of one of the wheels; null where nobody saw it."""
    others: list[int]
    """Further measurements of the same wheel: it was seen more than once."""
    reason: str | None
    """Why it was not seen, or seen but not measured."""
    wheelset_side: Side | None
    """Which wheel of its wheelset it is: a wheelset may run turned about."""
    jumps: dict[Quantity, JumpModel]


class DifferenceModel(_Out):
    """Left less right, mm."""

    value: float
    u95: float
    status: Status


class BackToBackModel(_Out):
    """Distance between the flange backs of an axle, mm; null with a reason where not measured."""

    value: float | None
    u95: float | None
    status: Status
    alarm: Alarm
    pairs: int
    """Shots of left and right at one time that it is the mean of."""
    reason: str | None
    """Why there is no value."""


class AxleModel(_Out):
    """One axle of a train, in the order of passing; also one that nobody saw."""

    place: int
    """Among these rows, from 1."""
    number: int | None
    """In the train, from 1; null where nothing tells it."""
    placing: Placing
    """Whether its number is certain, inferred, or not known."""
    remark: str | None
    """What is behind a number that is not certain."""
    passed_at: datetime | None
    wheelset: str | None
    vehicle: str | None
    position: str | None
    left: AxleWheelModel
    right: AxleWheelModel
    differences: dict[Quantity, DifferenceModel]
    back_to_back: BackToBackModel | None
    """Null where the settings did not say how left and right stand to each other."""


class VehicleModel(_Out):
    """The greatest difference between the wheels of a vehicle, mm, and which two they are."""

    vehicle: str
    quantity: Quantity
    value: float
    u95: float
    status: Status
    greatest: str
    smallest: str


class AlarmModel(_Out):
    """A reading that somebody is to look at."""

    kind: AlarmKind
    level: Alarm
    quantity: Quantity | Literal["back_to_back"]
    value: float
    """The value; of a jump the change, mm."""
    u95: float
    place: int
    number: int | None
    side: Side | None
    """Null of a whole axle."""
    wheelset: str | None
    text: str


class TrainModel(_Out):
    """A train, axle for axle; without axles until its measuring has ended."""

    counted: int | None
    """Axles the controller counted."""
    remark: str | None
    """Why no axle is told its wheelset though a consist was named."""
    no_back_to_back: str | None
    """Why no axle has a back-to-back distance though both sides were measured."""
    axles: list[AxleModel]
    vehicles: list[VehicleModel]
    alarms: list[AlarmModel]


class RateModel(_Out):
    """Change in mm for each day or pass, with the half-width of its 95 % interval."""

    value_mm: float
    u95_mm: float


class TrendValueModel(_Out):
    """A value of one pass, mm."""

    pass_id: str
    at: datetime
    value: float
    u95: float
    status: Status
    alarm: Alarm
    jump: float | None
    """Change since the pass before, where it is a jump."""


class QuantityTrendModel(_Out):
    """The values of one quantity, oldest first, and the line through those since the last jump."""

    values: list[TrendValueModel]
    fitted: int
    """Values that the rates rest on."""
    per_day: RateModel | None
    per_pass: RateModel | None
    scatter: float | None
    """Scatter about the line, in sigmas: 1 is as the values' u95 say."""


class SideTrendModel(_Out):
    """One wheel of a wheelset; its side is the wheelset's own."""

    side: Side
    passes: int
    quantities: dict[Quantity, QuantityTrendModel]


class WheelsetTrendModel(_Out):
    """How the wheels of a wheelset change from pass to pass."""

    wheelset: str
    sides: list[SideTrendModel]
