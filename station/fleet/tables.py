"""The tables of the fleet's database: what each station has told, by the station's own keys.

Every row is named by the station, the epoch of the station's store, and the station's own key.  A
store that was brought back from a backup may give its keys away again: it does so in a new epoch,
and what an earlier one told stays.  Where both tell of the same thing, the earlier row is
superseded, not overwritten.
"""

from datetime import datetime

from sqlalchemy import (
    JSON,
    BigInteger,
    ForeignKeyConstraint,
    Index,
    MetaData,
    Text,
    UniqueConstraint,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from station.store import JsonObject, UtcDateTime


class FleetTable(DeclarativeBase):
    """Base of the tables; their names leave room for a station's store in the same database."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s",
            "pk": "pk_%(table_name)s",
        }
    )
    type_annotation_map = {datetime: UtcDateTime(), JsonObject: JSON()}


class FleetStation(FleetTable):
    """A station, and what it said when it was heard last."""

    __tablename__ = "fleet_stations"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str]
    software: Mapped[str]
    first_heard_at: Mapped[datetime]  # by the fleet's clock, as all that says "heard"
    last_heard_at: Mapped[datetime]
    clock_ahead_s: Mapped[float]  # of the station's clock against the fleet's
    unsent: Mapped[int]  # changes it had still to send
    unsent_since: Mapped[datetime | None]  # when it made the oldest of them
    limits: Mapped[JsonObject | None]  # that it judges readings by; see `told_limits`


class FleetEpoch(FleetTable):
    """One life of a station's store, and how far it has told: the mark stands with the rows."""

    __tablename__ = "fleet_epochs"
    __table_args__ = (
        UniqueConstraint("station", "store_epoch"),
        ForeignKeyConstraint(["station"], ["fleet_stations.id"]),
    )

    station: Mapped[str] = mapped_column(primary_key=True)
    epoch: Mapped[int] = mapped_column(primary_key=True)  # from 1, in the order of their coming
    store_epoch: Mapped[str]  # as the station names it
    began_at: Mapped[datetime]
    heard_at: Mapped[datetime]
    number: Mapped[int] = mapped_column(BigInteger)  # of the last change that is here
    token: Mapped[str | None]  # of the batch it came with; None before the first


class OfEpoch(FleetTable):
    """What one life of a station's store tells."""

    __abstract__ = True

    station: Mapped[str] = mapped_column(primary_key=True, sort_order=-2)
    epoch: Mapped[int] = mapped_column(primary_key=True, autoincrement=False, sort_order=-1)


def _of_epoch() -> ForeignKeyConstraint:
    return ForeignKeyConstraint(
        ["station", "epoch"], ["fleet_epochs.station", "fleet_epochs.epoch"]
    )


class FleetRefusal(OfEpoch):
    """A change that this database does not take; the station went on with the next."""

    __tablename__ = "fleet_refusals"
    __table_args__ = (_of_epoch(),)

    kind: Mapped[str] = mapped_column(primary_key=True)
    key: Mapped[str] = mapped_column(primary_key=True)
    number: Mapped[int] = mapped_column(BigInteger)
    why: Mapped[str] = mapped_column(Text)
    refused_at: Mapped[datetime]


class FleetPass(OfEpoch):
    """A train that passed a station."""

    __tablename__ = "fleet_passes"
    __table_args__ = (
        _of_epoch(),
        Index("ix_fleet_passes_station_opened_at", "station", "opened_at"),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    opened_at: Mapped[datetime]  # by the station's clock, as all that the station tells
    finished_at: Mapped[datetime | None]
    state: Mapped[str]
    train: Mapped[str | None]
    axles: Mapped[int | None]
    reason: Mapped[str | None] = mapped_column(Text)
    superseded: Mapped[bool] = mapped_column(default=False)  # a later epoch tells of it too


def _of_pass() -> ForeignKeyConstraint:
    own = ["station", "epoch", "pass_id"]
    return ForeignKeyConstraint(
        own, [f"fleet_passes.{name}" for name in ("station", "epoch", "id")]
    )


class FleetWheel(OfEpoch):
    """A wheel measured: its readings with their alarms."""

    __tablename__ = "fleet_wheels"
    __table_args__ = (
        _of_pass(),
        Index("ix_fleet_wheels_station_epoch_pass_id", "station", "epoch", "pass_id"),
    )

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    pass_id: Mapped[str]
    recording_id: Mapped[str]
    frame: Mapped[int]
    sensor: Mapped[str]  # or the rig
    calibration_id: Mapped[str]
    rig_calibration_id: Mapped[str | None]
    reference: Mapped[str]
    regime: Mapped[str | None]
    software: Mapped[str]
    measured_at: Mapped[datetime]
    readings: Mapped[JsonObject]  # by quantity: value, u95, status, alarm
    reason: Mapped[str | None] = mapped_column(Text)  # why it was not measured
    profile: Mapped[JsonObject | None]  # where the station sends them


class FleetAxle(OfEpoch):
    """One wheel of an axle of a pass: which wheelset it is of, also of one that nobody saw."""

    __tablename__ = "fleet_axles"
    __table_args__ = (
        _of_pass(),
        Index("ix_fleet_axles_wheelset", "wheelset"),
    )

    pass_id: Mapped[str] = mapped_column(primary_key=True)
    place: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    side: Mapped[str] = mapped_column(primary_key=True)
    number: Mapped[int | None]
    placing: Mapped[str]
    passed_at: Mapped[datetime | None]
    wheel_id: Mapped[int | None]  # the surest measurement of it
    wheelset: Mapped[str | None]
    wheelset_side: Mapped[str | None]
    vehicle: Mapped[str | None]
    position: Mapped[str | None]
    jumps: Mapped[JsonObject]
    back_to_back: Mapped[JsonObject | None]
    reason: Mapped[str | None] = mapped_column(Text)
    remark: Mapped[str | None] = mapped_column(Text)


class FleetAlarm(OfEpoch):
    """A reading beyond a limit, of the measurement that stands for its wheel."""

    __tablename__ = "fleet_alarms"
    __table_args__ = (
        _of_pass(),
        Index("ix_fleet_alarms_at", "at"),
        Index("ix_fleet_alarms_station_epoch_pass_id", "station", "epoch", "pass_id"),
    )

    wheel_id: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    quantity: Mapped[str] = mapped_column(primary_key=True)
    pass_id: Mapped[str]
    at: Mapped[datetime]
    alarm: Mapped[str]
    value: Mapped[float]
    u95: Mapped[float]
    wheelset: Mapped[str | None]
    wheelset_side: Mapped[str | None]


class FleetCalibration(OfEpoch):
    """A calibration that came into force on a sensor or a rig, with its figures."""

    __tablename__ = "fleet_calibrations"
    __table_args__ = (_of_epoch(),)

    of: Mapped[str] = mapped_column(primary_key=True)  # sensor or rig
    name: Mapped[str] = mapped_column(primary_key=True)
    version: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    calibration_id: Mapped[str]
    created_at: Mapped[datetime]
    activated_at: Mapped[datetime]
    activated_by: Mapped[str]
    method: Mapped[str | None]
    passed: Mapped[bool | None]
    rms_dots_px: Mapped[float | None]
    rms_stripe_px: Mapped[float | None]
    superseded: Mapped[bool] = mapped_column(default=False)


class FleetRecalibration(OfEpoch):
    """A night: what a recalibration of a sensor found, and what followed."""

    __tablename__ = "fleet_recalibrations"
    __table_args__ = (
        _of_epoch(),
        Index("ix_fleet_recalibrations_station_sensor", "station", "sensor", "ordered_at"),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    sensor: Mapped[str]
    state: Mapped[str]
    ordered_at: Mapped[datetime]
    ended_at: Mapped[datetime | None]
    outcome: Mapped[str | None]
    action: Mapped[str | None]
    alarm: Mapped[bool | None]
    present_version: Mapped[int | None]  # the activation that it was held against
    figures: Mapped[JsonObject | None]
    reasons: Mapped[JsonObject | None]
    reason: Mapped[str | None] = mapped_column(Text)
    superseded: Mapped[bool] = mapped_column(default=False)
