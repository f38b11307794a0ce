"""results.json: the wheels of a measurement, one row a wheel, measured or not."""

import math
from collections.abc import Iterator
from datetime import datetime
from typing import Any, Literal, Self

import numpy as np
from pydantic import AwareDatetime, Field, model_validator

from measure import (
    Alarm,
    Placing,
    Profile,
    Quantity,
    ReferenceProfile,
    SensorShare,
    Side,
    Status,
    Survey,
    WheelQuality,
    WheelReadings,
)
from station.documents.axle import AxleDocument, BackToBackDocument, StandingDocument
from station.documents.base import Document


class ReadingDocument(Document):
    """One quantity of one wheel, mm; `value` and `u95` are null where it could not be measured."""

    value: float | None = None
    u95: float | None = None
    status: Status
    alarm: Alarm


_MISSING = ReadingDocument(status=Status.MISSING, alarm=Alarm.UNKNOWN)


def _empty(value: object) -> bool:
    """Tell what only rigs have: the rows of sensors by themselves stay as they were."""
    return not value


class ProfileDocument(Document):
    """The measured profile: distance from the flange back, height over the nominal tread."""

    d_mm: tuple[float, ...]
    h_mm: tuple[float, ...]
    sigma_mm: tuple[float, ...]
    wear_mm: tuple[float | None, ...] | None = None
    """Reference minus height, aligned at flange back and tip; null behind the tip."""
    sensors: tuple[str, ...] = Field(default=(), exclude_if=_empty)
    """The sensors of a rig, in the order of the bits of `seen_by`; absent where one saw all."""
    seen_by: tuple[int, ...] | None = Field(default=None, exclude_if=_empty)
    """Which sensors have points there: bit k is set for sensor k."""

    @model_validator(mode="after")
    def _each_point_was_seen(self) -> Self:
        if self.seen_by is not None and len(self.seen_by) != len(self.d_mm):
            raise ValueError(f"seen_by has {len(self.seen_by)} of {len(self.d_mm)} points")
        return self

    def profile(self) -> Profile:
        """Return the profile itself."""
        return Profile(
            np.array(self.d_mm),
            np.array(self.h_mm),
            np.array(self.sigma_mm),
            None if self.seen_by is None else np.array(self.seen_by, dtype=np.int64),
        )

    def seen_by_names(self, point: int) -> tuple[str, ...]:
        """Return the sensors of a rig that have points where a point of the profile is."""
        bits = 0 if self.seen_by is None else self.seen_by[point]
        return tuple(name for bit, name in enumerate(self.sensors) if bits >> bit & 1)


class HeaderDocument(Document):
    """What the header of a profile's file says: its own readings, mm, and its fields."""

    claimed: dict[Quantity, float] = Field(default_factory=dict)
    levels_mm: dict[Literal["L1", "L2", "L3"], float] = Field(default_factory=dict)
    """Where it has them taken, and so have we: below the tip, the tape circle, above it."""
    fields: dict[str, str] = Field(default_factory=dict)


class WheelDocument(Document):
    """One wheel as seen by a sensor or a rig; one that could not be measured has a reason."""

    source: str
    sensor: str
    """Or the rig."""
    sensors: tuple[str, ...] = Field(default=(), exclude_if=_empty)
    """The sensors of a rig whose points are in the readings; absent of a sensor by itself."""
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
    diameter: ReadingDocument = _MISSING
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
    standing: StandingDocument | None = Field(default=None, exclude_if=_empty)
    """Where its flange back stood in its rig; absent where that was not seen."""

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
    survey: Survey | None = None,
) -> WheelDocument:
    """Return the row of a measured wheel, or of one that could not be measured.

    With a `reference` the profile says how its wear is spread; with a `survey` the row keeps where
    the flange back stood.
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
        sensors=tuple(_giving(answer.quality)) if len(answer.quality.sensors) > 1 else (),
        frame=frame,
        frames=frames,
        time=time,
        profile=_profile(answer.profile, answer.quality.sensors, reference),
        quality=_quality(answer.quality),
        reason=answer.reason,
        header=header,
        standing=StandingDocument.of(answer.places, survey),
        **readings,
    )


def _giving(quality: WheelQuality) -> Iterator[str]:
    """Yield the sensors that gave points."""
    for name, share in quality.by_sensor.items():
        if share.points:
            yield name


def _profile(
    profile: Profile | None, sensors: tuple[str, ...], reference: ReferenceProfile | None
) -> ProfileDocument | None:
    if profile is None:
        return None
    seen_by = None if profile.seen_by is None else tuple(profile.seen_by.tolist())
    return ProfileDocument(
        sensors=() if seen_by is None else sensors,
        seen_by=seen_by,
        d_mm=tuple(profile.d_mm.tolist()),
        h_mm=tuple(profile.h_mm.tolist()),
        sigma_mm=tuple(profile.sigma_mm.tolist()),
        wear_mm=None if reference is None else _wear(profile, reference),
    )


def _wear(profile: Profile, reference: ReferenceProfile) -> tuple[float | None, ...]:
    wear = profile.wear_mm(reference).tolist()
    return tuple(None if math.isnan(each) else each for each in wear)


def _quality(quality: WheelQuality) -> dict[str, object]:
    shares = {name: _share(share) for name, share in quality.by_sensor.items()}
    of_rig = {"by_sensor": shares} if len(quality.sensors) > 1 else {}
    return {
        **of_rig,
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


def _share(share: SensorShare) -> dict[str, object]:
    """Return what one sensor of a rig gave, as the row keeps it."""
    return {
        "points": share.points,
        "reason": share.reason,
        "aside_mm": None if share.aside_mm is None else list(share.aside_mm),
        "sigma_aside_mm": None if share.sigma_aside_mm is None else list(share.sigma_aside_mm),
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
    rigs: dict[str, str] = Field(default_factory=dict, exclude_if=_empty)
    """Fingerprints of the rigs that wheels were measured on, by rig."""
    reference: str
    regime: str | None = None
    """The regime whose limits raised the alarms."""
    wheels: tuple[WheelDocument, ...]
    axles: tuple[AxleDocument, ...] = Field(default=(), exclude_if=_empty)
    """What both wheels of an axle say together; absent where one side alone was measured."""
    no_back_to_back: str | None = Field(default=None, exclude_if=_empty)
    """Why no axle has a back-to-back distance."""

    def calibration_of(self, wheel: WheelDocument) -> str | None:
        """Return the fingerprint of the calibration, or rig, that a wheel was measured with."""
        return self.rigs.get(wheel.sensor) or self.calibrations.get(wheel.sensor, self.calibration)

    def back_to_back_of(self, wheel: WheelDocument) -> BackToBackDocument | None:
        """Return the distance of the axle that a wheel is on; None where that is not known."""
        if wheel.axle is None:
            return None
        own = (axle.back_to_back for axle in self.axles if axle.axle == wheel.axle)
        return next(own, None)

    @property
    def measured(self) -> int:
        """How many wheels have readings."""
        return sum(wheel.reason is None for wheel in self.wheels)
