"""Passes, calibration sessions, and what the sensors recorded of them."""

from datetime import datetime

from sqlalchemy import ForeignKey, Index, Text
from sqlalchemy.orm import Mapped, mapped_column

from station.store.states import EndedBy, PassState, SessionState
from station.store.tables.base import JsonObject, Table


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
