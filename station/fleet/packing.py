"""From the rows of a station's store to those that the fleet keeps of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic_core import from_json
from sqlalchemy import select
from sqlalchemy.orm import Session

from measure import Alarm, Quantity
from station.fleet.tables import (
    FleetAlarm,
    FleetAxle,
    FleetCalibration,
    FleetPass,
    FleetRecalibration,
    FleetWheel,
    OfEpoch,
)
from station.store import (
    Activation,
    AxleWheel,
    Calibration,
    Change,
    JsonObject,
    Measurement,
    Pass,
    Recalibration,
    RigActivation,
    RigCalibration,
)
from station.store.changes import ChangeKind
from station.store.measured import axles_of, profiles_of, wheels_of

Row = dict[str, Any]
_BEYOND = {Alarm.WARNING.value, Alarm.ALARM.value}


@dataclass(frozen=True, slots=True)
class Packed:
    """What the fleet is to know of one change; in place of what it knew of the same thing.

    Attributes
    ----------
    number
        Of the change.
    rows
        By table, without station and epoch; the first table is that of the thing itself.
    """

    number: int
    kind: ChangeKind
    key: str
    rows: Mapping[type[OfEpoch], Sequence[Row]]

    @property
    def size(self) -> int:
        """How many rows it is."""
        return sum(len(rows) for rows in self.rows.values())


def pack(session: Session, changes: Sequence[Change], *, profiles: bool) -> Iterator[Packed]:
    """Yield what there is to send of some changes, in their order."""
    for change in changes:
        kind = ChangeKind(change.kind)
        yield Packed(change.number, kind, change.key, _rows(session, kind, change.key, profiles))


def _rows(
    session: Session, kind: ChangeKind, key: str, profiles: bool
) -> Mapping[type[OfEpoch], Sequence[Row]]:
    match kind:
        case ChangeKind.PASS:
            row = session.get(Pass, key)
            return {} if row is None else _of_pass(session, row, profiles=profiles)
        case ChangeKind.ACTIVATION:
            activation = session.get(Activation, int(key))
            return {} if activation is None else _of_activation(session, activation)
        case ChangeKind.RIG_ACTIVATION:
            of_rig = session.get(RigActivation, int(key))
            return {} if of_rig is None else _of_rig_activation(session, of_rig)
        case ChangeKind.RECALIBRATION:
            night = session.get(Recalibration, key)
            return {} if night is None else {FleetRecalibration: [_picked(night, _NIGHT)]}


_PASS = ("id", "opened_at", "finished_at", "train", "axles", "reason")
_WHEEL = (
    "id",
    "pass_id",
    "recording_id",
    "frame",
    "sensor",
    "calibration_id",
    "rig_calibration_id",
    "reference",
    "regime",
    "software",
    "measured_at",
)
_AXLE = (
    "pass_id",
    "place",
    "number",
    "passed_at",
    "wheelset",
    "vehicle",
    "position",
    "jumps",
    "back_to_back",
    "reason",
    "remark",
)
_NIGHT = (
    "id",
    "sensor",
    "state",
    "ordered_at",
    "ended_at",
    "outcome",
    "action",
    "alarm",
    "present_version",
    "figures",
    "reasons",
    "reason",
)


def _picked(row: object, names: Sequence[str]) -> Row:
    return {name: getattr(row, name) for name in names}


def _of_pass(
    session: Session, row: Pass, *, profiles: bool
) -> Mapping[type[OfEpoch], Sequence[Row]]:
    measured = session.scalars(
        select(Measurement).where(Measurement.pass_id == row.id).order_by(Measurement.id)
    ).all()
    shapes = profiles_of(session, measured) if profiles else {}
    axles = axles_of(session, row.id)
    # A wheel measured once more, by other means, raises no second alarm.
    standing = {wheel.id for wheel in wheels_of(session, row)}
    return {
        FleetPass: [{**_picked(row, _PASS), "state": row.state.value}],
        FleetWheel: [_wheel(wheel, shapes.get(wheel.id)) for wheel in measured],
        FleetAxle: [_axle(axle) for axle in axles],
        FleetAlarm: list(_alarms(row, [w for w in measured if w.id in standing], axles)),
    }


def _readings(wheel: JsonObject) -> JsonObject:
    return {q.value: wheel[q.value] for q in Quantity if wheel.get(q.value) is not None}


def _wheel(row: Measurement, profile: JsonObject | None) -> Row:
    return {
        **_picked(row, _WHEEL),
        "readings": _readings(row.wheel),
        "reason": row.wheel.get("reason"),
        "profile": profile,
    }


def _axle(row: AxleWheel) -> Row:
    own = row.wheelset_side
    return {
        **_picked(row, _AXLE),
        "side": row.side.value,
        "placing": row.placing.value,
        "wheel_id": row.measurement_id,
        "wheelset_side": None if own is None else own.value,
    }


def _alarms(
    row: Pass, measured: Sequence[Measurement], axles: Sequence[AxleWheel]
) -> Iterator[Row]:
    places = {axle.measurement_id: axle for axle in axles}
    for wheel in measured:
        place = places.get(wheel.id)
        own = None if place is None else place.wheelset_side
        for quantity, reading in _readings(wheel.wheel).items():
            if reading["alarm"] in _BEYOND and reading["value"] is not None:
                yield {
                    "wheel_id": wheel.id,
                    "quantity": quantity,
                    "pass_id": row.id,
                    "at": row.opened_at,
                    "alarm": reading["alarm"],
                    "value": reading["value"],
                    "u95": reading["u95"],
                    "wheelset": None if place is None else place.wheelset,
                    "wheelset_side": None if own is None else own.value,
                }


def _of_activation(session: Session, row: Activation) -> Mapping[type[OfEpoch], Sequence[Row]]:
    calibration = session.get_one(Calibration, row.calibration_id)
    own = {"of": "sensor", "name": row.sensor, "method": calibration.method}
    return {FleetCalibration: [{**own, **_in_force(row, calibration)}]}


def _of_rig_activation(
    session: Session, row: RigActivation
) -> Mapping[type[OfEpoch], Sequence[Row]]:
    calibration = session.get_one(RigCalibration, row.rig_calibration_id)
    own = {"of": "rig", "name": row.rig, "method": None}
    return {FleetCalibration: [{**own, **_in_force(row, calibration)}]}


def _in_force(row: Activation | RigActivation, calibration: Calibration | RigCalibration) -> Row:
    rms = _rms(calibration.document)
    return {
        "version": row.version,
        "calibration_id": calibration.id,
        "created_at": calibration.created_at,
        "activated_at": row.activated_at,
        "activated_by": row.activated_by,
        "passed": calibration.passed,
        "rms_dots_px": rms.get("dots_px"),
        "rms_stripe_px": rms.get("stripe_px"),
    }


def _rms(document: str | None) -> JsonObject:
    # Not through its model: a document of an older version still has its residuals.
    try:
        found = from_json(document or "{}")
    except ValueError:
        return {}
    rms = found.get("rms") if isinstance(found, dict) else None
    return rms if isinstance(rms, dict) else {}
