"""The tables of replays: what was to be measured once more, with what, and what came of it."""

from datetime import datetime

from sqlalchemy import ForeignKey, Index
from sqlalchemy.orm import Mapped, mapped_column

from station.store.tables.base import JsonObject, Table


class Replay(Table):
    """Recordings that somebody had measured once more; its state is that of its job."""

    __tablename__ = "replays"
    __table_args__ = (Index("ix_replays_ordered_at_id", "ordered_at", "id"),)

    id: Mapped[str] = mapped_column(primary_key=True)
    ordered_at: Mapped[datetime]
    ordered_by: Mapped[str]
    job_id: Mapped[str]
    pass_id: Mapped[str | None] = mapped_column(ForeignKey("passes.id"))
    steps: Mapped[JsonObject]  # {"steps": [[recording, ...], ...]}; those of a rig's shots together
    calibrations: Mapped[JsonObject]  # by sensor
    rig_calibration_id: Mapped[str | None] = mapped_column(ForeignKey("rig_calibrations.id"))
    reference: Mapped[str]
    results: Mapped[JsonObject]  # by the first recording of a step, as far as it has come


class ReplayMeasurement(Table):
    """That a replay came to a measurement: one it made, or one that was there and says the same."""

    __tablename__ = "replay_measurements"

    replay_id: Mapped[str] = mapped_column(ForeignKey("replays.id"), primary_key=True)
    measurement_id: Mapped[int] = mapped_column(ForeignKey("measurements.id"), primary_key=True)
