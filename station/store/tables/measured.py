"""Wheels as they were measured, and the axles of a train that they stand on."""

from datetime import datetime

from sqlalchemy import ForeignKey, Index, Text, UniqueConstraint, text
from sqlalchemy.orm import Mapped, mapped_column

from measure import Placing, Side
from station.store.tables.base import JsonObject, Table


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
