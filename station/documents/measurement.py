"""results.json: the wheels of a measurement, one row a wheel, measured or not."""

from typing import Any, Literal

from pydantic import AwareDatetime, Field

from station.documents.base import Document


class ReadingDocument(Document):
    """One quantity of one wheel; `value` and `u95` are absent where it could not be measured."""

    value: float | None = None
    u95: float | None = None
    status: str
    alarm: str


class ProfileDocument(Document):
    """The measured profile: distance from the flange back, height over the nominal tread."""

    d_mm: tuple[float, ...]
    h_mm: tuple[float, ...]
    sigma_mm: tuple[float, ...]


class WheelDocument(Document):
    """One wheel as seen by one sensor; an unmeasurable wheel has a reason instead of readings."""

    source: str
    sensor: str
    frame: int | None = None
    """The frame (its id in a recording, its place among pictures) that carried most weight."""
    frames: tuple[int, ...] = ()
    """All frames of the wheel."""
    time: AwareDatetime | None = None
    readings: dict[str, ReadingDocument] = Field(default_factory=dict)
    profile: ProfileDocument | None = None
    quality: dict[str, Any] = Field(default_factory=dict)
    reason: str | None = None


class MeasurementDocument(Document):
    """One measurement of one or more sources with one calibration."""

    format: Literal["treadline-measurement"] = "treadline-measurement"
    version: Literal[1] = 1
    created: AwareDatetime
    software: str
    calibration: str
    """SHA-256 of the calibration that was used."""
    reference: str
    wheels: tuple[WheelDocument, ...]

    @property
    def measured(self) -> int:
        """How many wheels have readings."""
        return sum(wheel.reason is None for wheel in self.wheels)
