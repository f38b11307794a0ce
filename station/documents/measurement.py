"""results.json: the wheels of a measurement, one row a wheel, measured or not."""

from datetime import datetime
from typing import Any, Literal

from pydantic import AwareDatetime, Field

from measure import Alarm, Profile, Quantity, Status, WheelQuality, WheelReadings
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


def wheel_document(
    answer: WheelReadings,
    *,
    source: str,
    sensor: str,
    frame: int | None = None,
    frames: tuple[int, ...] = (),
    time: datetime | None = None,
) -> WheelDocument:
    """Return the row of a measured wheel, or of one that could not be measured."""
    readings = {
        quantity.value: ReadingDocument(
            value=reading.value, u95=reading.u95, status=reading.status, alarm=reading.alarm
        )
        for quantity, reading in answer.readings.items()
    }
    return WheelDocument(
        source=source,
        sensor=sensor,
        frame=frame,
        frames=frames,
        time=time,
        profile=_profile(answer.profile),
        quality=_quality(answer.quality),
        reason=answer.reason,
        **readings,
    )


def _profile(profile: Profile | None) -> ProfileDocument | None:
    if profile is None:
        return None
    return ProfileDocument(
        d_mm=tuple(profile.d_mm.tolist()),
        h_mm=tuple(profile.h_mm.tolist()),
        sigma_mm=tuple(profile.sigma_mm.tolist()),
    )


def _quality(quality: WheelQuality) -> dict[str, object]:
    return {
        "points": quality.points,
        "left_out": {cause.value: count for cause, count in quality.left_out.items()},
        "coverage": quality.coverage,
        "speckle_share": quality.speckle_share,
        "frames_used": list(quality.frames),
        "axle_offset_mm": quality.axle_offset_mm,
        "sheet_yaw_deg": quality.sheet_yaw_deg,
        "wear_max_at_d_mm": quality.wear_max_at_d_mm,
        "unmeasured": {str(frame): reason for frame, reason in quality.unmeasured.items()},
    }


class MeasurementDocument(Document):
    """One measurement of one or more sources with one calibration."""

    format: Literal["treadline-measurement"] = "treadline-measurement"
    version: Literal[1] = 1
    created: AwareDatetime
    software: str
    calibration: str | None
    """Fingerprint of the calibration that was used; null where profiles were given."""
    reference: str
    wheels: tuple[WheelDocument, ...]

    @property
    def measured(self) -> int:
        """How many wheels have readings."""
        return sum(wheel.reason is None for wheel in self.wheels)
