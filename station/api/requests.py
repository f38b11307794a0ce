"""What goes in over HTTP: names, numbers and bodies, and how far each may go."""

from typing import Annotated

from fastapi import Path, Query
from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from station.documents import BOARD_SIGMA_MM
from station.operations import MethodName, ReferenceName
from station.settings import SensorId
from station.trains import Consist, Named, Orientation, Wheelset

_ID_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
RecordingName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,127}$")]
CallersId = Annotated[str, StringConstraints(pattern=_ID_PATTERN)]
WheelsetId = Annotated[str, StringConstraints(pattern=_ID_PATTERN)]
WheelsetInPath = Annotated[
    str, Path(pattern=_ID_PATTERN, description="As a consist names it, at most 64 letters.")
]
IdInPath = Annotated[
    str, Path(pattern=_ID_PATTERN, description="Letters, digits, . _ and -, at most 64.")
]
RigInPath = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
RecordingInPath = Annotated[str, Path(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,127}$")]
SensorInPath = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
Limit = Annotated[int, Query(ge=1, le=1000, description="Rows of a page at most.")]
# Some databases hold no NUL, and no page shows the others.
_PRINTABLE = r"^[^\x00-\x1f\x7f]*$"
TrainName = Annotated[str, StringConstraints(max_length=128, pattern=_PRINTABLE)]
TargetGiven = Annotated[str, StringConstraints(max_length=64)]
Count = Annotated[int, Field(ge=0, le=100_000)]
Label = Annotated[str, StringConstraints(min_length=1, max_length=64, pattern=_PRINTABLE)]


class _In(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


class WheelsetRequest(_In):
    """A wheelset of a train."""

    wheelset: WheelsetId
    vehicle: Label | None = None
    """The vehicle it is under: its wheels are compared with each other."""
    position: Label | None = None
    """Its place in the vehicle."""
    orientation: Orientation = Orientation.FORWARD
    """Whether its left wheel runs on the train's left, or it runs turned about."""

    def told(self) -> Wheelset:
        """Return it as the train has it."""
        return Wheelset(self.wheelset, self.vehicle, self.position, self.orientation)


class _WithConsist(_In):
    consist: tuple[WheelsetRequest | WheelsetId, ...] | None = Field(
        default=None, min_length=1, max_length=1000
    )
    """The train's wheelsets in the order in which they pass: names, or more of each."""

    def named(self, when: Named) -> Consist | None:
        """Return the consist, if the call names one."""
        if self.consist is None:
            return None
        told = (each if isinstance(each, str) else each.told() for each in self.consist)
        return Consist(
            tuple(Wheelset(each) if isinstance(each, str) else each for each in told), named=when
        )


class PassRequest(_WithConsist):
    """A train comes."""

    train: TrainName | None = None
    """What the controller calls the train."""


class FinishRequest(_WithConsist):
    """The train has gone."""

    axles: Count | None = None
    """Axles counted: one wheel, one trigger for every sensor."""
    triggers: dict[SensorId, Count] = Field(default_factory=dict)
    """Triggers of single sensors, where they differ from `axles`."""


class SessionRequest(_In):
    """Pictures for a calibration are to be taken, by a sensor or by all of a rig."""

    sensor: SensorId | None = None
    rig: SensorId | None = None
    """In place of a sensor: a picture is then taken by each of its sensors."""
    target: TargetGiven
    """For example dots:7x8:12, or chessboard:9x6:5."""
    targets: dict[SensorId, TargetGiven] = Field(default_factory=dict, max_length=16)
    """Targets of single sensors of a rig, where they see another board."""


class CalibrationRequest(_In):
    """A calibration is to be solved from a session, or from recordings."""

    sensor: SensorId
    method: MethodName = "joint"
    session: CallersId | None = None
    recordings: tuple[RecordingName, ...] = Field(default=(), max_length=64)
    target: TargetGiven | None = None
    """Absent: the session's."""
    laser_off: tuple[RecordingName, ...] = Field(default=(), max_length=64)
    """Recordings of the same poses without laser."""


class RigCalibrationRequest(_In):
    """A rig is to be calibrated from a session, or from a recording of each of its sensors."""

    rig: SensorId
    session: CallersId | None = None
    recordings: dict[SensorId, RecordingName] = Field(default_factory=dict, max_length=16)
    target: TargetGiven | None = None
    """Absent: the session's."""
    targets: dict[SensorId, TargetGiven] = Field(default_factory=dict, max_length=16)
    """Targets of single sensors, where they see another board."""
    same_board: bool = False
    """Whether it is one board that all sensors see, not one each, rigidly joined."""
    board_sigma_mm: float = Field(default=BOARD_SIGMA_MM, gt=0.0, le=1.0)
    """How far each dot is from its place on the board, one sigma, mm."""


class ReplayRequest(_In):
    """Recordings are to be measured once more, with calibrations chosen here."""

    recordings: tuple[RecordingName, ...] = Field(default=(), max_length=1000)
    """Also uploaded ones."""
    pass_id: CallersId | None = Field(default=None, alias="pass")
    """In place of recordings: all of its own."""
    calibrations: dict[SensorId, CallersId] = Field(default_factory=dict, max_length=16)
    """One for each sensor of the recordings."""
    rig_calibration: CallersId | None = None
    """For sensors of a rig, which are then measured together; with it `calibrations` may lack those
    that they were recorded, or the rig was solved, with."""
    reference: ReferenceName | None = None
    """Reference profile; absent: the station's."""


class ActivationRequest(_In):
    """A calibration is to come into force."""

    calibration: CallersId
