"""The tables of measuring while a train passes: how far it has come, what is not yet certain."""

from sqlalchemy import BigInteger, ForeignKey
from sqlalchemy.orm import Mapped, mapped_column

from station.store.tables.base import Table


class Following(Table):
    """How far a recording has been measured while it was written; gone when that has ended."""

    __tablename__ = "followings"

    recording_id: Mapped[str] = mapped_column(ForeignKey("recordings.id"), primary_key=True)
    reference: Mapped[str]
    regime: Mapped[str]  # whose limits raised the alarms
    software: Mapped[str]
    part: Mapped[int]  # the file in which measuring goes on, from 1
    offset_bytes: Mapped[int] = mapped_column(
        BigInteger
    )  # where in it the chunk of the next frame begins
    frames: Mapped[int]  # of the recording before that
    shown_before: Mapped[bool]  # whether the series of frames there has shown a wheel already


class EarlyReading(Table):
    """That a measurement was made before its wheel was certainly over."""

    __tablename__ = "early_readings"

    measurement_id: Mapped[int] = mapped_column(ForeignKey("measurements.id"), primary_key=True)
