"""What somebody is to look at on a train: values beyond limits, and changes between passes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from measure import Alarm, Quantity, Reading, Side
from station.store import AxleWheel

_RAISED = frozenset({Alarm.WARNING, Alarm.ALARM})


class AlarmKind(StrEnum):
    """What an alarm rests on: a value beyond its limit, or a change from one pass to the next."""

    LIMIT = "limit"
    JUMP = "jump"


@dataclass(frozen=True, slots=True)
class AxleAlarm:
    """A reading that somebody is to look at."""

    kind: AlarmKind
    level: Alarm
    quantity: Quantity | Literal["back_to_back"]
    value: float
    """The value, of a jump the change, mm."""
    u95: float
    place: int
    number: int | None
    side: Side | None
    """None of a whole axle."""
    wheelset: str | None
    text: str


def name_of(row: AxleWheel) -> str:
    """Return what people call a wheel."""
    return f"{_axle_name(row)} {row.side}"


def _axle_name(row: AxleWheel) -> str:
    return f"axle {row.number}" if row.number is not None else f"row {row.place}"


def wheel_alarms(
    row: AxleWheel, readings: Mapping[Quantity, Reading], regime: str | None
) -> Iterator[AxleAlarm]:
    """Yield the alarms of one wheel, its readings judged by the limits of a regime."""
    for quantity, reading in readings.items():
        if reading.alarm in _RAISED and reading.value is not None and reading.u95 is not None:
            said = _beyond(quantity, reading.value, reading.u95, reading.alarm, regime)
            text = f"{name_of(row)}: {said}"
            value, u95 = reading.value, reading.u95
            yield _alarm(row, AlarmKind.LIMIT, reading.alarm, quantity, value, u95, text)
    for name, jump in row.jumps.items():
        text = (
            f"{name_of(row)}: {name} changed by {jump['change']:+.2f} ± {jump['u95']:.2f} mm "
            f"since pass {jump['before']} (limit {jump['limit']:g}): a damaged or newly turned "
            "wheel, or a consist that mixes wheelsets up"
        )
        change, u95 = jump["change"], jump["u95"]
        yield _alarm(row, AlarmKind.JUMP, Alarm.ALARM, Quantity(name), change, u95, text)


def axle_alarms(row: AxleWheel, regime: str | None) -> Iterator[AxleAlarm]:
    """Yield the alarm of the axle that a wheel is on, where its back-to-back distance raised one.

    Both rows of an axle hold the distance; ask one of them.
    """
    found = row.back_to_back
    if found is None or found["value"] is None:
        return
    level, value, u95 = Alarm(found["alarm"]), found["value"], found["u95"]
    if level in _RAISED:
        said = _beyond("back_to_back", value, u95, level, regime)
        yield AxleAlarm(
            kind=AlarmKind.LIMIT,
            level=level,
            quantity="back_to_back",
            value=value,
            u95=u95,
            place=row.place,
            number=row.number,
            side=None,
            wheelset=row.wheelset,
            text=f"{_axle_name(row)}: {said}",
        )


def _beyond(what: str, value: float, u95: float, level: Alarm, regime: str | None) -> str:
    by = f" ({regime})" if regime else ""
    where = "beyond" if level is Alarm.ALARM else "near"
    return f"{what} {value:.2f} ± {u95:.2f} mm is {where} its limit{by}"


def _alarm(
    row: AxleWheel,
    kind: AlarmKind,
    level: Alarm,
    quantity: Quantity,
    value: float,
    u95: float,
    text: str,
) -> AxleAlarm:
    return AxleAlarm(
        kind=kind,
        level=level,
        quantity=quantity,
        value=value,
        u95=u95,
        place=row.place,
        number=row.number,
        side=row.side,
        wheelset=row.wheelset,
        text=text,
    )
