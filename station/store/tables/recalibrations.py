"""The tables of recalibrations: what was found and decided, and the checks of the piece."""

from datetime import datetime

from sqlalchemy import ForeignKey, Index, Text, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from station.store.states import RecalibrationState
from station.store.tables.base import JsonObject, Table


class Recalibration(Table):
    """One recalibration of a sensor, with its figures, its decision and the reasons for it."""

    __tablename__ = "recalibrations"
    # However many processes look at the clock, a night has one recalibration of a sensor.
    __table_args__ = (
        UniqueConstraint("sensor", "due_at"),
        Index("ix_recalibrations_sensor_ordered_at", "sensor", "ordered_at"),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    state: Mapped[RecalibrationState] = mapped_column(index=True)
    sensor: Mapped[str]
    due_at: Mapped[datetime | None]  # by the schedule; none of one that somebody ordered
    ordered_at: Mapped[datetime]
    ordered_by: Mapped[str]
    job_id: Mapped[str]
    ended_at: Mapped[datetime | None]
    taken: Mapped[JsonObject | None]  # what it is made from: recordings, target, piece
    pictures_at: Mapped[datetime | None]  # the oldest of what was taken
    calibration_id: Mapped[str | None] = mapped_column(ForeignKey("calibrations.id"))
    present_id: Mapped[str | None] = mapped_column(ForeignKey("calibrations.id"))
    present_version: Mapped[int | None]  # the activation that it was held against
    findings: Mapped[JsonObject]  # step by step, as far as it has come
    outcome: Mapped[str | None]
    action: Mapped[str | None]
    reasons: Mapped[JsonObject | None]  # {"reasons": [...]}
    figures: Mapped[JsonObject | None]
    alarm: Mapped[bool | None]
    reason: Mapped[str | None] = mapped_column(Text)  # why it failed
    activated_version: Mapped[int | None]  # where its calibration came into force
    answered_by: Mapped[str | None]
    answered_at: Mapped[datetime | None]
    answer: Mapped[str | None] = mapped_column(Text)  # why the person answered so
    measuring_job_id: Mapped[str | None]  # that measures passes again
    version: Mapped[int]  # rises with every change that a person could overlook


class KeptPieceCheck(Table):
    """What a calibration made of the reference piece; later ones are held against its first."""

    __tablename__ = "piece_checks"

    id: Mapped[int] = mapped_column(primary_key=True)
    sensor: Mapped[str]
    calibration_id: Mapped[str] = mapped_column(ForeignKey("calibrations.id"), index=True)
    recalibration_id: Mapped[str] = mapped_column(ForeignKey("recalibrations.id"), index=True)
    checked_at: Mapped[datetime]
    verdict: Mapped[str]
    document: Mapped[str] = mapped_column(Text)
