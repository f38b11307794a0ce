"""results.json: the wheels of a measurement, one row a wheel, measured or not."""

from typing import Any, Literal

from pydantic import AwareDatetime, Field

from measure import Alarm, Quantity, Status
from station.documents.base import Document


class ReadingDocument(Document):
    """One quantity of one wheel, mm; `value` and `u95` are null where it could not be measured."""

    value: float | None = None
    u95: float | None = None
    status: Status
    alarm: Alarm


_MISSING = ReadingDocument(status=Status.MISSING, alarm=Alarm.UNKNOWN)


class ProfileDocument(Document):
    """The measured profile: distance from the flange back, height over the nominal tread."""

    d_mm: tuple[float, ...]
    h_mm: tuple[float, ...]
    sigma_mm: tuple[float, ...]


class WheelDocument(Document):
    """One wheel as seen by one sensor; one that could not be measured has a reason."""

    source: str
    sensor: str
    frame: int | None = None
    """The frame (its id in a recording, its place among pictures) that carried most weight."""
    frames: tuple[int, ...] = ()
    """All frames of the wheel."""
    time: AwareDatetime | None = None
    flange_height: ReadingDocument = _MISSING
    flange_thickness_10: ReadingDocument = _MISSING
    flange_thickness_12: ReadingDocument = _MISSING
    flange_gradient_qr: ReadingDocument = _MISSING
    tread_wear: ReadingDocument = _MISSING
    tread_wear_at_70: ReadingDocument = _MISSING
    tread_wear_max: ReadingDocument = _MISSING
    hollow_depth: ReadingDocument = _MISSING
    profile: ProfileDocument | None = None
    quality: dict[str, Any] = Field(default_factory=dict)
    reason: str | None = None
    """Why nothing was measured."""

    @property
    def readings(self) -> dict[Quantity, ReadingDocument]:
        """Every quantity."""
        return {quantity: getattr(self, quantity.value) for quantity in Quantity}


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
