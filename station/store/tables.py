"""The tables of the store.  Whoever changes one writes the migration beside it."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    DateTime,
    Dialect,
    Enum,
    ForeignKey,
    Index,
    MetaData,
    Text,
    UniqueConstraint,
    text,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column
from sqlalchemy.types import TypeDecorator

from measure import Placing, Side
from station.store.states import (
    CalibrationState,
    EndedBy,
    JobState,
    PassState,
    RecalibrationState,
    SessionState,
    State,
)

JsonObject = dict[str, Any]


class UtcDateTime(TypeDecorator[datetime]):
    """A moment; SQLite keeps no time zone, so UTC is put back on the way out."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        return None if value is None else value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        return value.replace(tzinfo=UTC) if value is not None and value.tzinfo is None else value


def _state(kind: type[State]) -> Enum:
    # Text, not a database enum: a state added later then needs no migration.
    return Enum(
        kind, native_enum=False, length=16, values_callable=lambda states: [s.value for s in states]
    )


class Table(DeclarativeBase):
    """Base of the tables; constraints get names that a migration can use."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s",
            "pk": "pk_%(table_name)s",
        }
    )
    type_annotation_map = {
        datetime: UtcDateTime(),
        JsonObject: JSON(),
        PassState: _state(PassState),
        SessionState: _state(SessionState),
        EndedBy: _state(EndedBy),
        CalibrationState: _state(CalibrationState),
        JobState: _state(JobState),
        RecalibrationState: _state(RecalibrationState),
        Side: _state(Side),
        Placing: _state(Placing),
    }


class Pass(Table):
    """One train going by, named by the controller."""

    __tablename__ = "passes"
    __table_args__ = (
        Index("ix_passes_opened_at_id", "opened_at", "id"),
        Index("ix_passes_train_opened_at", "train", "opened_at"),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    state: Mapped[PassState] = mapped_column(index=True)
    train: Mapped[str | None]
    opened_at: Mapped[datetime]
    finished_at: Mapped[datetime | None]
    ended_by: Mapped[EndedBy | None]
    ended_why: Mapped[str | None] = mapped_column(Text)  # where it was not the controller
    reason: Mapped[str | None] = mapped_column(Text)
    job_id: Mapped[str | None]
    axles: Mapped[int | None]  # as the controller counted them
    consist: Mapped[JsonObject | None]  # {"named": "put" or "finish", "wheelsets": [...]}


class CalibrationSession(Table):
    """Pictures of a target taken one by one, to calibrate a sensor or a rig from."""

    __tablename__ = "calibration_sessions"

    id: Mapped[str] = mapped_column(primary_key=True)
    state: Mapped[SessionState] = mapped_column(index=True)
    sensor: Mapped[str | None]  # or
    rig: Mapped[str | None]  # all sensors of one
    target: Mapped[str]
    targets: Mapped[JsonObject | None]  # of a rig's sensors, where each has a board of its own
    pictures: Mapped[int]
    opened_at: Mapped[datetime]
    finished_at: Mapped[datetime | None]
    ended_by: Mapped[EndedBy | None]
    reason: Mapped[str | None] = mapped_column(Text)


class Recording(Table):
    """What one sensor recorded of a pass or a session, and how its frames add up."""

    __tablename__ = "recordings"
    __table_args__ = (Index("ix_recordings_sensor_opened_at_id", "sensor", "opened_at", "id"),)

    id: Mapped[str] = mapped_column(primary_key=True)
    sensor: Mapped[str] = mapped_column(index=True)
    pass_id: Mapped[str | None] = mapped_column(ForeignKey("passes.id"), index=True)
    session_id: Mapped[str | None] = mapped_column(
        ForeignKey("calibration_sessions.id"), index=True
    )
    path: Mapped[str]  # relative to the folder of the station's data
    opened_at: Mapped[datetime] = mapped_column(index=True)
    closed_at: Mapped[datetime | None]
    calibration_id: Mapped[str | None] = mapped_column(ForeignKey("calibrations.id"))
    rig_calibration_id: Mapped[str | None] = mapped_column(ForeignKey("rig_calibrations.id"))
    expected: Mapped[int | None]  # frames the controller counted triggers for
    recorded: Mapped[int | None]
    lost: Mapped[int | None]
    repeated: Mapped[int | None]
    refused: Mapped[int | None]
    complete: Mapped[bool | None]
    recovered: Mapped[bool] = mapped_column(default=False)
    summary: Mapped[str | None] = mapped_column(Text)
    files: Mapped[int | None]  # a long recording goes on in a next one
    compacted_at: Mapped[datetime | None]
    deleted_at: Mapped[datetime | None]
    deleted_why: Mapped[str | None] = mapped_column(Text)
    sha256: Mapped[str | None] = mapped_column(index=True)  # of one that was uploaded


class Calibration(Table):
    """A calibration of a sensor: solving, ready, or failed with a reason."""

    __tablename__ = "calibrations"

    id: Mapped[str] = mapped_column(primary_key=True)
    state: Mapped[CalibrationState]
    sensor: Mapped[str] = mapped_column(index=True)
    target: Mapped[str]
    method: Mapped[str]
    recording_ids: Mapped[JsonObject]  # {"recordings": [...], "laser_off": [...]}
    created_at: Mapped[datetime]
    reason: Mapped[str | None] = mapped_column(Text)
    job_id: Mapped[str]
    document: Mapped[str | None] = mapped_column(Text)
    passed: Mapped[bool | None]  # whether its figures keep the limits
    refused_at: Mapped[datetime | None]  # where a person will not have it come into force
    refused_by: Mapped[str | None]
    refused_why: Mapped[str | None] = mapped_column(Text)


class CalibrationPoints(Table):
    """The points of a calibration as CSV: megabytes, so not beside the calibration's row."""

    __tablename__ = "calibration_points"

    calibration_id: Mapped[str] = mapped_column(ForeignKey("calibrations.id"), primary_key=True)
    csv: Mapped[str] = mapped_column(Text)


class Activation(Table):
    """A calibration coming into force on a sensor; the last one counts, the rest is history."""

    __tablename__ = "activations"
    # Two writers who read the same version cannot both go on from it, on any database.
    __table_args__ = (UniqueConstraint("sensor", "version"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    sensor: Mapped[str]
    version: Mapped[int]
    calibration_id: Mapped[str] = mapped_column(ForeignKey("calibrations.id"))
    activated_at: Mapped[datetime]
    activated_by: Mapped[str]


class RigCalibration(Table):
    """A calibration of a rig: uploaded, or solving, ready, or failed with a reason."""

    __tablename__ = "rig_calibrations"

    id: Mapped[str] = mapped_column(primary_key=True)
    state: Mapped[CalibrationState]
    rig: Mapped[str] = mapped_column(index=True)
    ordered: Mapped[JsonObject | None]  # what to solve it from; none where it was uploaded
    created_at: Mapped[datetime]
    reason: Mapped[str | None] = mapped_column(Text)
    job_id: Mapped[str | None]
    document: Mapped[str | None] = mapped_column(Text)
    passed: Mapped[bool | None]  # whether its figures keep the limits
    refused_at: Mapped[datetime | None]  # where a person will not have it come into force
    refused_by: Mapped[str | None]
    refused_why: Mapped[str | None] = mapped_column(Text)


class RigActivation(Table):
    """A rig's calibration coming into force; the last one counts, the rest is history."""

    __tablename__ = "rig_activations"
    __table_args__ = (UniqueConstraint("rig", "version"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    rig: Mapped[str]
    version: Mapped[int]
    rig_calibration_id: Mapped[str] = mapped_column(ForeignKey("rig_calibrations.id"))
    activated_at: Mapped[datetime]
    activated_by: Mapped[str]


class Measurement(Table):
    """One wheel measured: from which frame, by which calibration and software, with what result."""

    __tablename__ = "measurements"
    # Measuring again with the same calibration, as after a crash, adds nothing; with another
    # calibration, of the sensor or of its rig, or against another reference, it adds a row and
    # leaves the old one.
    __table_args__ = (
        Index(
            "uq_measurements_of_sensors",
            "recording_id",
            "frame",
            "calibration_id",
            "reference",
            unique=True,
            sqlite_where=text("rig_calibration_id IS NULL"),
            postgresql_where=text("rig_calibration_id IS NULL"),
        ),
        Index(
            "uq_measurements_of_rigs",
            "recording_id",
            "frame",
            "calibration_id",
            "rig_calibration_id",
            "reference",
            unique=True,
            sqlite_where=text("rig_calibration_id IS NOT NULL"),
            postgresql_where=text("rig_calibration_id IS NOT NULL"),
        ),
        Index("ix_measurements_sensor_id", "sensor", "id"),
        Index("ix_measurements_pass_id_id", "pass_id", "id"),
    )

    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[str] = mapped_column(ForeignKey("recordings.id"))
    frame: Mapped[int]
    calibration_id: Mapped[str] = mapped_column(ForeignKey("calibrations.id"))
    rig_calibration_id: Mapped[str | None] = mapped_column(ForeignKey("rig_calibrations.id"))
    sensor: Mapped[str]  # or the rig, of a wheel that its sensors measured together
    pass_id: Mapped[str | None] = mapped_column(ForeignKey("passes.id"))
    reference: Mapped[str]
    software: Mapped[str]
    measured_at: Mapped[datetime]
    wheel: Mapped[JsonObject]  # but its profile
    regime: Mapped[str | None]  # whose limits raised the alarms


class MeasurementProfile(Table):
    """The profile of a measured wheel: 40 kB that lists and trends never read."""

    __tablename__ = "measurement_profiles"

    measurement_id: Mapped[int] = mapped_column(ForeignKey("measurements.id"), primary_key=True)
    profile: Mapped[JsonObject]


class AxleWheel(Table):
    """One wheel of an axle of a pass, also one that nobody saw."""

    __tablename__ = "axle_wheels"
    __table_args__ = (
        UniqueConstraint("pass_id", "place", "side"),
        Index("ix_axle_wheels_wheelset_wheelset_side_id", "wheelset", "wheelset_side", "id"),
        Index("ix_axle_wheels_measurement_id", "measurement_id"),
        Index("ix_axle_wheels_wheelset_measurement_id", "wheelset", "measurement_id"),
    )

    id: Mapped[int] = mapped_column(primary_key=True)
    pass_id: Mapped[str] = mapped_column(ForeignKey("passes.id"))
    place: Mapped[int]  # among the rows of the pass, from 1
    side: Mapped[Side]
    number: Mapped[int | None]  # of the axle in the train, from 1
    placing: Mapped[Placing]
    passed_at: Mapped[datetime | None]
    remark: Mapped[str | None] = mapped_column(Text)
    measurement_id: Mapped[int | None] = mapped_column(ForeignKey("measurements.id"))
    others: Mapped[JsonObject]  # {"measurements": [...]}: where it was seen more than once
    reason: Mapped[str | None] = mapped_column(Text)  # why it was not seen
    wheelset: Mapped[str | None]
    wheelset_side: Mapped[Side | None]  # of the wheelset itself: it may run turned about
    vehicle: Mapped[str | None]
    position: Mapped[str | None]
    jumps: Mapped[JsonObject]  # by quantity, against the wheelset's pass before
    back_to_back: Mapped[JsonObject | None]  # of the axle; absent where no track was known


class Job(Table):
    """Long work of the worker process."""

    __tablename__ = "jobs"
    __table_args__ = (
        Index("ix_jobs_created_at_id", "created_at", "id"),
        Index("ix_jobs_subject_created_at", "subject", "created_at"),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    kind: Mapped[str]
    subject: Mapped[str]  # the pass or calibration it works on
    state: Mapped[JobState] = mapped_column(index=True)
    progress: Mapped[float]
    doing: Mapped[str]
    error: Mapped[str | None] = mapped_column(Text)
    created_at: Mapped[datetime]
    started_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]


class Key(Table):
    """A bearer key: its name and what it may do; the key itself only as a hash."""

    __tablename__ = "keys"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str]
    scopes: Mapped[JsonObject]  # {"scopes": [...]}
    secret_sha256: Mapped[str]
    created_at: Mapped[datetime]
    expires_at: Mapped[datetime | None]
    revoked_at: Mapped[datetime | None]
    last_used_at: Mapped[datetime | None]  # to within some minutes


class KeptAnswer(Table):
    """The answer to a call that carried an Idempotency-Key, for when the call comes again."""

    __tablename__ = "kept_answers"

    caller: Mapped[str] = mapped_column(primary_key=True)
    key: Mapped[str] = mapped_column(primary_key=True)
    fingerprint: Mapped[str]  # of method, address and body
    asked_at: Mapped[datetime] = mapped_column(index=True)
    status: Mapped[int | None]  # absent while the call is being answered
    headers: Mapped[JsonObject | None]
    body: Mapped[bytes | None]


class AuditEntry(Table):
    """What somebody changed; rows are added and never touched again, which triggers see to."""

    __tablename__ = "audit_entries"
    __table_args__ = (Index("ix_audit_entries_subject_id", "subject", "id"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    at: Mapped[datetime]
    who: Mapped[str]
    address: Mapped[str | None]  # of the caller, where it came over the network
    action: Mapped[str]
    kind: Mapped[str]  # of thing that was changed
    subject: Mapped[str]  # its name
    before: Mapped[JsonObject | None]
    after: Mapped[JsonObject | None]
