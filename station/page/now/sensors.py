"""What the card of a sensor tells: what its camera does, its counters, what it measures by."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from sqlalchemy.orm import Session

from station.capture import CaptureState, CaptureStatus
from station.page.now.calibrations import InForce, of_rig, of_sensor
from station.settings import SensorSettings, StationSettings
from station.store import session_in_progress
from station.store.watched import has_frames
from station.watching import Outlook, Trouble, TroubleKind, part_of_sensor

_CLOCK_SOURCE, _CLOCK_DRIFT = "clock_source", "clock_drift_ppm"


class Doing(StrEnum):
    """What a sensor does, in a person's words: each is a text and a colour."""

    IDLE = "idle"
    ARMED = "armed"
    """It records, and no frame has come yet."""
    RECORDING = "recording"
    BLIND = "blind"
    """It records, and its camera is away."""
    RECORDED = "recorded"
    AWAY = "away"
    """Its camera is not there."""
    SILENT = "silent"
    """Nothing is heard of its capture process."""


_DOING: Mapping[CaptureState, Doing] = {
    CaptureState.UNAVAILABLE: Doing.AWAY,
    CaptureState.IDLE: Doing.IDLE,
    CaptureState.RECORDING: Doing.RECORDING,
    CaptureState.BLIND: Doing.BLIND,
    CaptureState.RECORDED: Doing.RECORDED,
}


_OF_CAMERA = frozenset({
    TroubleKind.CAPTURE_SILENT,
    TroubleKind.CAMERA_LOST,
    TroubleKind.CAMERA_UNFIT,
})
_OF_CALIBRATION = frozenset({TroubleKind.CALIBRATION_DOUBTFUL, TroubleKind.RECALIBRATION_ASKS})


@dataclass(frozen=True, slots=True)
class Counters:
    """What became of frames: of the recording being made, or since the capture process began."""

    recorded: int
    lost: int
    refused: int
    repeated: int
    resent_packets: int

    @classmethod
    def of(cls, status: CaptureStatus) -> "Counters":
        """Return those of the recording being made, or else of all so far."""
        if doing_of(status) in {Doing.ARMED, Doing.RECORDING, Doing.BLIND, Doing.RECORDED}:
            return cls(**{name: getattr(status, name) for name in cls.__slots__})
        return cls(**{name: status.totals.get(name, 0) for name in cls.__slots__})


@dataclass(frozen=True, slots=True)
class SensorCard:
    """One sensor at one moment."""

    id: str
    side: str
    address: str
    trigger: str
    doing: Doing
    troubles: tuple[Trouble, ...]
    """Of this sensor alone, the gravest first."""
    status: CaptureStatus | None
    """None where nothing is heard of its capture process."""
    counters: Counters | None
    calibration: InForce | None
    rig: str | None
    rig_calibration: InForce | None
    pictured: bool
    """Whether it has recorded a frame that is still there."""
    held_by: str | None
    """The calibration session that holds it."""

    @property
    def records(self) -> bool:
        """Whether a recording is open on it."""
        return self.doing in {Doing.ARMED, Doing.RECORDING, Doing.BLIND, Doing.RECORDED}

    @property
    def of_camera(self) -> tuple[Trouble, ...]:
        """The troubles of its camera: whoever stands before it can help them."""
        return tuple(each for each in self.troubles if each.kind in _OF_CAMERA)

    @property
    def doubtful(self) -> bool:
        """Whether its calibration may measure wrongly, or one waits for a person."""
        return any(each.kind in _OF_CALIBRATION for each in self.troubles)

    @property
    def clock(self) -> str | None:
        """Where its frames' times come from; None where that was not told yet."""
        return None if self.status is None else self.status.clock.get(_CLOCK_SOURCE)

    @property
    def drift_ppm(self) -> float | None:
        """By how much its clock runs fast; None where it was watched too briefly."""
        told = "" if self.status is None else self.status.clock.get(_CLOCK_DRIFT, "")
        return float(told) if told else None


def doing_of(status: CaptureStatus | None) -> Doing:
    """Return what a sensor does by what its capture process says."""
    if status is None:
        return Doing.SILENT
    doing = _DOING[status.state]
    return Doing.ARMED if doing is Doing.RECORDING and status.recorded == 0 else doing


def _recorded_now(status: CaptureStatus | None) -> bool:
    return status is not None and status.state is CaptureState.RECORDING and status.recorded > 0


def sensor_cards(
    session: Session, settings: StationSettings, outlook: Outlook
) -> tuple[SensorCard, ...]:
    """Return the cards of all sensors, in the order of the settings."""
    return tuple(_card(session, settings, sensor, outlook) for sensor in settings.sensors)


def _card(
    session: Session, settings: StationSettings, sensor: SensorSettings, outlook: Outlook
) -> SensorCard:
    status, rig = outlook.statuses.get(sensor.id), settings.rig_with(sensor.id)
    held = session_in_progress(session, sensor.id)
    own = (each for each in outlook.troubles if each.part == part_of_sensor(sensor.id))
    return SensorCard(
        id=sensor.id,
        side=sensor.side,
        address=sensor.address,
        trigger=sensor.trigger,
        doing=doing_of(status),
        troubles=tuple(own),
        status=status,
        counters=None if status is None else Counters.of(status),
        calibration=of_sensor(session, sensor.id),
        rig=None if rig is None else rig.id,
        rig_calibration=None if rig is None else of_rig(session, rig.id),
        pictured=_recorded_now(status) or has_frames(session, sensor.id),
        held_by=None if held is None else held.id,
    )
