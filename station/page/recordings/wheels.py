"""The wheels that were measured from a recording, each with how it stands."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from measure import Alarm, Quantity, Side
from station.store import AxleWheel, JsonObject, Measurement, Recording


class Standing(StrEnum):
    """What a wheel is shown as; the texts of the page say each in words."""

    ALARM = "alarm"
    WARNING = "warning"
    FINE = "fine"
    UNMEASURED = "unmeasured"

    @property
    def kind(self) -> str:
        """How its badge looks."""
        return _KINDS[self]


_KINDS = {
    Standing.ALARM: "bad",
    Standing.WARNING: "warn",
    Standing.FINE: "good",
    Standing.UNMEASURED: "",
}


@dataclass(frozen=True, slots=True)
class Wheel:
    """A measured wheel of a recording."""

    row: Measurement
    standing: Standing
    own: bool
    """Whether its frames are those of the recording; else it is of another one of the rig."""
    frames: tuple[int, ...]
    """All of its frames, as the camera numbers them; the one that carried most weight at least."""
    time: str | None
    """When it was seen, UTC, as RFC 3339 has it."""
    axle: int | None
    side: Side | None
    wheelset: str | None
    reason: str | None
    """Why nothing was measured."""

    @property
    def address(self) -> str:
        """Where the wheel has a page of its own."""
        return f"/wheels/{self.row.id}"

    def marked(self) -> dict[str, Any]:
        """Return what the time line of the page marks it by: its frames, or when it was seen."""
        frames = (self.frames[0], self.frames[-1]) if self.own else (None, None)
        return {
            "first": frames[0],
            "last": frames[1],
            "time": self.time,
            "standing": self.standing,
        }


def wheels_in(
    recording: Recording, measurements: Iterable[Measurement], places: Mapping[int, AxleWheel]
) -> tuple[Wheel, ...]:
    """Return the wheels of measurements, with where in the train they are."""
    return tuple(_wheel(recording, row, places.get(row.id)) for row in measurements)


def own_readings(
    recording: Recording, measured: Sequence[Measurement], together: Sequence[Measurement] = ()
) -> list[Measurement]:
    """Return of all measurements of a recording those that count as its own, by frame.

    They are by the calibrations it was recorded under, else by whatever measured it first: what was
    measured once more stands behind, with the replay that it came from.

    Parameters
    ----------
    measured
        In the order they were made.
    together
        Those of its pass that its sensor saw with others of its rig, as it was recorded.
    """
    recorded = [row for row in measured if _as_recorded(row, recording)]
    if not recorded and not together:
        first = [row for row in measured if _means(row) == _means(measured[0])]
        return sorted(first, key=lambda row: row.frame)
    # A pass is measured against the station's reference before any other.
    reference = min([*recorded, *together], key=lambda row: row.id).reference
    own = sorted(recorded, key=lambda row: row.frame)
    return [row for row in [*own, *together] if row.reference == reference]


def _as_recorded(row: Measurement, recording: Recording) -> bool:
    return (row.calibration_id, row.rig_calibration_id) == (
        recording.calibration_id,
        recording.rig_calibration_id,
    )


def _means(row: Measurement) -> tuple[str, str | None, str]:
    return row.calibration_id, row.rig_calibration_id, row.reference


def standing_of(wheel: JsonObject) -> Standing:
    """Return how a wheel stands by the alarms of its readings."""
    alarms = {(wheel.get(quantity) or {}).get("alarm") for quantity in Quantity}
    if wheel.get("reason") is not None:
        return Standing.UNMEASURED
    if Alarm.ALARM in alarms:
        return Standing.ALARM
    return Standing.WARNING if Alarm.WARNING in alarms else Standing.FINE


def _wheel(recording: Recording, row: Measurement, place: AxleWheel | None) -> Wheel:
    frames = tuple(sorted({row.frame, *row.wheel.get("frames", ())}))
    return Wheel(
        row=row,
        standing=standing_of(row.wheel),
        own=row.recording_id == recording.id,
        frames=frames,
        time=row.wheel.get("time"),
        axle=None if place is None else place.number,
        side=None if place is None else place.side,
        wheelset=None if place is None else place.wheelset,
        reason=row.wheel.get("reason"),
    )
