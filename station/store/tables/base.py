"""What all tables have in common: names of constraints, how moments and states are kept."""

from datetime import UTC, datetime
from typing import Any, TypeVar

from sqlalchemy import JSON, DateTime, Dialect, Enum, MetaData
from sqlalchemy.orm import DeclarativeBase
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


Row = TypeVar("Row", bound=Table)
