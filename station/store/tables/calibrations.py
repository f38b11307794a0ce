"""Calibrations of sensors and of rigs, and which of them came into force when."""

from datetime import datetime

from sqlalchemy import ForeignKey, Text, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from station.store.states import CalibrationState
from station.store.tables.base import JsonObject, Table


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


class RigCalibrationPoints(Table):
    """The points of one sensor's pictures in a rig's calibration as CSV; none of one uploaded."""

    __tablename__ = "rig_calibration_points"

    rig_calibration_id: Mapped[str] = mapped_column(
        ForeignKey("rig_calibrations.id"), primary_key=True
    )
    sensor: Mapped[str] = mapped_column(primary_key=True)
    csv: Mapped[str] = mapped_column(Text)


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
