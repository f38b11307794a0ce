"""The long work of the worker process."""

from datetime import datetime

from sqlalchemy import Index, Text
from sqlalchemy.orm import Mapped, mapped_column

from station.store.states import JobState
from station.store.tables.base import Table


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
