"""What goes in over HTTP about recalibrations."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from station.api.requests import CallersId
from station.settings import SensorId


class _In(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


class RecalibrationRequest(_In):
    """A sensor is to be recalibrated."""

    sensor: SensorId
    sessions: tuple[CallersId, ...] = Field(default=(), max_length=16)
    """Calibration sessions to take; absent: those that are new, or one that the station takes."""


class RefusalRequest(_In):
    """Why a calibration is not to come into force."""

    reason: Annotated[
        str,
        StringConstraints(
            min_length=1, max_length=500, strip_whitespace=True, pattern=r"^[^\x00]*$"
        ),
    ]
    """It stays with the calibration."""


class AnswerRequest(_In):
    """What a person answers."""

    action: Literal["activate", "refuse"]
    reason: Annotated[
        str,
        StringConstraints(
            min_length=1, max_length=500, strip_whitespace=True, pattern=r"^[^\x00]*$"
        ),
    ]
    """Why; it stays with the sensor's calibrations."""
