"""results.json: the wheels of a measurement, one row a wheel, measured or not."""

import math
from datetime import datetime
from typing import Any, Literal

import numpy as np
from pydantic import AwareDatetime, Field

from measure import (
    Alarm,
    Placing,
    Profile,
    Quantity,
    ReferenceProfile,
    Side,
    Status,
    WheelQuality,
    WheelReadings,
)
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
    wear_mm: tuple[float | None, ...] | None = None
    """Reference minus height, aligned at flange back and tip; null behind the tip."""

    def profile(self) -> Profile:
        """Return the profile itself."""
        return Profile(np.array(self.d_mm), np.array(self.h_mm), np.array(self.sigma_mm))


class HeaderDocument(Document):
    """What the header of a profile's file says: its own readings, mm, and its fields."""

    claimed: dict[Quantity, float] = Field(default_factory=dict)
    levels_mm: dict[Literal["L1", "L2", "L3"], float] = Field(default_factory=dict)
    """Where it has them taken, and so have we: below the tip, the tape circle, above it."""
    fields: dict[str, str] = Field(default_factory=dict)


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
    axle: int | None = None
    """Its axle's number in the train, from 1; null where that is not known."""
    side: Side | None = None
    """The side of the train it is on."""
    placing: Placing | None = None
    """Whether its axle is certain, inferred, or not known; null where none was looked for."""
    wheelset: str | None = None
    """What the train's consist calls its wheelset."""
    header: HeaderDocument | None = None
    """What the file of a profile says of itself, beside what was read off its points."""

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
    reference: ReferenceProfile | None = None,
    header: HeaderDocument | None = None,
) -> WheelDocument:
    """Return the row of a measured wheel, or of one that could not be measured.

    With a `reference` the profile says how its wear is spread.
    """
    readings: dict[str, Any] = {
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
        profile=_profile(answer.profile, reference),
        quality=_quality(answer.quality),
        reason=answer.reason,
        header=header,
        **readings,
    )


def _profile(profile: Profile | None, reference: ReferenceProfile | None) -> ProfileDocument | None:
    if profile is None:
        return None
    return ProfileDocument(
        d_mm=tuple(profile.d_mm.tolist()),
        h_mm=tuple(profile.h_mm.tolist()),
        sigma_mm=tuple(profile.sigma_mm.tolist()),
        wear_mm=None if reference is None else _wear(profile, reference),
    )


def _wear(profile: Profile, reference: ReferenceProfile) -> tuple[float | None, ...]:
    wear = profile.wear_mm(reference).tolist()
    return tuple(None if math.isnan(each) else each for each in wear)


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
    """One measurement of one or more sources, with the calibration of each sensor."""

    format: Literal["treadline-measurement"] = "treadline-measurement"
    version: Literal[1] = 1
    created: AwareDatetime
    software: str
    calibration: str | None
    """Fingerprint of the calibration that was used; null where profiles were given, or several
    sensors measured."""
    calibrations: dict[str, str] = Field(default_factory=dict)
    """Those of several sensors, by sensor."""
    reference: str
    regime: str | None = None
    """The regime whose limits raised the alarms."""
    wheels: tuple[WheelDocument, ...]

    def calibration_of(self, wheel: WheelDocument) -> str | None:
        """Return the fingerprint of the calibration that a wheel was measured with."""
        return self.calibrations.get(wheel.sensor, self.calibration)

    @property
    def measured(self) -> int:
        """How many wheels have readings."""
        return sum(wheel.reason is None for wheel in self.wheels)
