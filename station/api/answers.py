"""What comes out over HTTP."""

from datetime import datetime
from typing import Any, Self

from pydantic import BaseModel, ConfigDict

from station.operations import PassView, SessionView
from station.store import (
    Activation,
    Calibration,
    CalibrationState,
    EndedBy,
    Job,
    JobState,
    PassState,
    Recording,
    RigActivation,
    RigCalibration,
    SessionState,
)


class Out(BaseModel):
    """What all answers have in common."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)


class RecordingModel(Out):
    """What one sensor recorded, and how its frames add up."""

    id: str
    sensor: str
    pass_id: str | None
    session_id: str | None
    opened_at: datetime
    closed_at: datetime | None
    calibration: str | None
    """The calibration in force when it was recorded."""
    rig_calibration: str | None
    """That of its rig."""
    expected: int | None
    """Frames the controller counted triggers for."""
    recorded: int | None
    lost: int | None
    repeated: int | None
    refused: int | None
    complete: bool | None
    recovered: bool
    """A crash had cut it short, and it was made whole."""
    summary: str | None
    files: int | None
    """Files it is in: a long recording goes on in a next one."""
    deleted_at: datetime | None
    """When its files made way for others; what was measured from them stays."""
    deleted_why: str | None

    @classmethod
    def of(cls, row: Recording) -> Self:
        same = cls.model_fields.keys() - {"calibration", "rig_calibration"}
        return cls(
            calibration=row.calibration_id,
            rig_calibration=row.rig_calibration_id,
            **{name: getattr(row, name) for name in same},
        )


class PassModel(Out):
    """A pass of a train."""

    id: str
    state: PassState
    train: str | None
    opened_at: datetime
    finished_at: datetime | None
    ended_by: EndedBy | None
    """The controller's finish, a time-out, or a start of the station at which nothing recorded any
    more; null while it goes on, where it could not be armed, and of passes before version 1.4."""
    reason: str | None
    job: str | None
    """The job that measures it."""
    axles: int | None
    """Axles the controller counted."""
    consist: list[dict[str, Any]] | None
    """The wheelsets of the train, as the controller named them."""
    recordings: list[RecordingModel]

    @classmethod
    def of(cls, view: PassView) -> Self:
        row = view.row
        return cls(
            id=row.id,
            state=row.state,
            train=row.train,
            opened_at=row.opened_at,
            finished_at=row.finished_at,
            ended_by=row.ended_by,
            reason="; ".join(why for why in (row.ended_why, row.reason) if why) or None,
            job=row.job_id,
            axles=row.axles,
            consist=None if row.consist is None else row.consist["wheelsets"],
            recordings=[RecordingModel.of(recording) for recording in view.recordings],
        )


class SessionModel(Out):
    """A calibration session."""

    id: str
    state: SessionState
    sensor: str | None
    rig: str | None
    """In place of a sensor: all of its sensors take pictures."""
    target: str
    targets: dict[str, str] | None
    """Of single sensors of a rig."""
    pictures: int
    opened_at: datetime
    finished_at: datetime | None
    ended_by: EndedBy | None
    """As of a pass; a person's finish is a controller's."""
    reason: str | None
    recordings: list[RecordingModel]

    @classmethod
    def of(cls, view: SessionView) -> Self:
        row = view.row
        return cls(
            id=row.id,
            state=row.state,
            sensor=row.sensor,
            rig=row.rig,
            target=row.target,
            targets=row.targets,
            pictures=row.pictures,
            opened_at=row.opened_at,
            finished_at=row.finished_at,
            ended_by=row.ended_by,
            reason=row.reason,
            recordings=[RecordingModel.of(recording) for recording in view.recordings],
        )


class JobModel(Out):
    """Long work of the worker."""

    id: str
    kind: str
    subject: str
    """The pass or calibration it works on."""
    state: JobState
    progress: float
    """Part done, 0 to 1."""
    doing: str
    error: str | None
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None

    @classmethod
    def of(cls, row: Job) -> Self:
        return cls(**{name: getattr(row, name) for name in cls.model_fields})


class CalibrationModel(Out):
    """A calibration of a sensor."""

    id: str
    state: CalibrationState
    sensor: str
    target: str
    method: str
    recordings: list[str]
    laser_off: list[str]
    created_at: datetime
    reason: str | None
    """Why there is none, where it failed."""
    job: str
    passed: bool | None
    """Whether its figures keep the limits."""
    refused_at: datetime | None
    """When a person refused it; it cannot come into force then."""
    refused_by: str | None
    refused_why: str | None
    document: dict[str, Any] | None
    """calibration.json."""

    @classmethod
    def of(cls, row: Calibration, document: dict[str, Any] | None) -> Self:
        return cls(
            id=row.id,
            state=row.state,
            sensor=row.sensor,
            target=row.target,
            method=row.method,
            recordings=row.recording_ids["recordings"],
            laser_off=row.recording_ids["laser_off"],
            created_at=row.created_at,
            reason=row.reason,
            job=row.job_id,
            passed=row.passed,
            refused_at=row.refused_at,
            refused_by=row.refused_by,
            refused_why=row.refused_why,
            document=document,
        )


class RigCalibrationModel(Out):
    """A calibration of a rig."""

    id: str
    state: CalibrationState
    rig: str
    ordered: dict[str, Any] | None
    """What it is solved from; null of an uploaded one."""
    created_at: datetime
    reason: str | None
    """Why there is none, where it failed."""
    job: str | None
    passed: bool | None
    """Whether its figures keep the limits."""
    refused_at: datetime | None
    """When a person refused it; it cannot come into force then."""
    refused_by: str | None
    refused_why: str | None
    document: dict[str, Any] | None
    """rig.json."""

    @classmethod
    def of(cls, row: RigCalibration, document: dict[str, Any] | None) -> Self:
        return cls(
            id=row.id,
            state=row.state,
            rig=row.rig,
            ordered=row.ordered,
            created_at=row.created_at,
            reason=row.reason,
            job=row.job_id,
            passed=row.passed,
            refused_at=row.refused_at,
            refused_by=row.refused_by,
            refused_why=row.refused_why,
            document=document,
        )


class RigActivationModel(Out):
    """The calibration in force on a rig."""

    rig: str
    calibration: str
    version: int
    activated_at: datetime
    activated_by: str

    @classmethod
    def of(cls, row: RigActivation) -> Self:
        return cls(
            rig=row.rig,
            calibration=row.rig_calibration_id,
            version=row.version,
            activated_at=row.activated_at,
            activated_by=row.activated_by,
        )


class ActivationModel(Out):
    """The calibration in force on a sensor."""

    sensor: str
    calibration: str
    version: int
    activated_at: datetime
    activated_by: str

    @classmethod
    def of(cls, row: Activation) -> Self:
        return cls(
            sensor=row.sensor,
            calibration=row.calibration_id,
            version=row.version,
            activated_at=row.activated_at,
            activated_by=row.activated_by,
        )
