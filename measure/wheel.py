"""A wheel from the pictures of it: readings with uncertainty, status and alarm."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from calib import Cause, FloatArray, LaserSensor, Rig, RigidTransform
from measure.gauging.uncertainty import COVERAGE_FACTOR, PICTURE_FLOOR_MM
from measure.laying.by_axle import Unmeasured
from measure.limits import Limits
from measure.merging.merged import Merged
from measure.mounting import Mounting, Survey
from measure.place import WheelPlace
from measure.profile import Profile
from measure.quantities import Quantity, Reading, Status
from measure.reading import ShotReadings, Value, read_shot
from measure.reference import ReferenceProfile
from measure.shot import Shot, WheelFrame
from measure.wheelset import Diameter, wheel_diameter


@dataclass(frozen=True, slots=True)
class SensorShare:
    """What one sensor of a rig contributed to the shot that carried most weight.

    Attributes
    ----------
    points
        Its points used.
    reason
        Why there are none; None where there are.
    aside_mm
        By how much its section lay aside from the first sensor's, along the axle and the radius,
        and was put in place so far as it had to be; None of the first, and where both see nothing
        in common.
    sigma_aside_mm
        Standard deviation of that, of the points' scatter.
    """

    points: int
    reason: str | None = None
    aside_mm: tuple[float, float] | None = None
    sigma_aside_mm: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class WheelQuality:
    """What stands behind the readings of a wheel.

    Attributes
    ----------
    frames
        Frames that gave readings.
    best_frame, best_sensor
        The one that carried most weight, and whose it is; the profile is that of its shot.
    points
        Stripe points used in it.
    left_out
        Points of it that were left out, by cause.
    coverage
        Share of the reference from tip to field side that it shows.
    speckle_share
        By which part of the stripe's width its points scatter beyond the pixels' noise.
    axle_offset_mm, sheet_yaw_deg
        Distance of the axle from the sheet, and angle between them; None without a mounting.
    wear_max_at_d_mm
        Where the greatest tread wear is.
    unmeasured
        Frames that gave no reading, and why.
    sensors
        Names of the rig's sensors, in the order of the bits of `Profile.seen_by`.
    by_sensor
        What each contributed.
    """

    frames: tuple[int, ...] = ()
    best_frame: int | None = None
    best_sensor: str = ""
    points: int = 0
    left_out: Mapping[Cause, int] = field(default_factory=dict)
    coverage: float = 0.0
    speckle_share: float | None = None
    axle_offset_mm: float | None = None
    sheet_yaw_deg: float | None = None
    wear_max_at_d_mm: float | None = None
    unmeasured: Mapping[int, str] = field(default_factory=dict)
    sensors: tuple[str, ...] = ()
    by_sensor: Mapping[str, SensorShare] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class WheelReadings:
    """All that is said of one wheel.

    Attributes
    ----------
    readings
        Every quantity, measured or missing.
    profile
        The measured profile, or None.
    quality
        What stands behind it.
    reason
        Why nothing could be measured; None where something was.
    places
        Where it stood, at each shot that gave readings.
    diameter
        What these say of its diameter, or why they say nothing; None without a survey.
    """

    readings: Mapping[Quantity, Reading]
    profile: Profile | None
    quality: WheelQuality
    reason: str | None
    places: tuple[WheelPlace, ...] = ()
    diameter: Diameter | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", MappingProxyType(dict(self.readings)))


def measure_wheel(
    frames: Sequence[WheelFrame],
    sensor: LaserSensor,
    reference: ReferenceProfile,
    *,
    mounting: Mounting | None = None,
    limits: Limits | None = None,
    assume_back: bool = False,
) -> WheelReadings:
    r"""Measure one wheel from the pictures of it.

    Parameters
    ----------
    frames
        The pictures in which it is seen; one suffices.
    sensor
        The calibrated sensor that took them.
    reference
        The profile that wear is counted from.
    mounting
        The survey of the installation. Without it the section is turned until its flange fits
        the reference, and every status is ``reference_assumed``: u95 holds a sheet that is out of
        the wheel's radial plane as one turned by eye is. Where the flange back does not show, or
        the flange shows a cut farther out, there is a reason and no reading.
    limits
        For the alarms; `Limits.default` where not given.
    assume_back
        Whether thickness and gradient may be read where the flange back is not seen but only
        inferred from the flange's shape; they are ``missing`` otherwise.

    Returns
    -------
    WheelReadings
        A wheel that cannot be measured has a reason, and readings that are all missing.

    Notes
    -----
    To first order a reading is a weighted sum of motions of the points; the weights follow from
    the local parabolas it is read off. Its variance adds up the stripe's noise (scaled by the
    scatter and correlation seen), the calibration's covariance, the survey's and axle's
    uncertainty; u95 is 1.96 times its root with a floor for the model. Several pictures are
    joined by generalised least squares, which knows which of these parts they share.
    """
    rig_from_camera = RigidTransform.identity() if mounting is None else mounting.rig_from_camera
    rig = Rig.of_one(sensor, rig_from_camera, frames[0].sensor if frames else "")
    shots = [Shot((frame,)) for frame in frames]
    return _measure(shots, rig, mounting, reference, limits, assume_back=assume_back)


def measure_wheel_on_rig(
    shots: Sequence[Shot],
    rig: Rig,
    survey: Survey,
    reference: ReferenceProfile,
    *,
    limits: Limits | None = None,
    assume_back: bool = False,
) -> WheelReadings:
    r"""Measure one wheel from the shots that the sensors of a rig took of it.

    Parameters
    ----------
    shots
        In which it is seen; one suffices. A shot may lack sensors: what the others can say is said.
    rig
        The sensors in one frame, with the covariance of all together.
    survey
        What is known of the installation and the wheels that pass.
    reference, limits, assume_back
        As of `measure_wheel`.

    Returns
    -------
    WheelReadings
        As of `measure_wheel`; its frames are those of the first sensor in each shot.

    Notes
    -----
    All sensors see one wheel on one axle. Where two see the same steel (flange tip, tread) the
    points of both must agree: what sensors vibrated against each other between their exposures is
    taken out so far as it shows above noise, rig and calibrations, and the same comparison tells
    how much of all these is left (`measure.merging.align.learn`). Points of several sensors at
    one place are then fused by their sigmas.
    """
    return _measure(shots, rig, survey, reference, limits, assume_back=assume_back)


def _measure(
    shots: Sequence[Shot],
    rig: Rig,
    survey: Survey | None,
    reference: ReferenceProfile,
    limits: Limits | None,
    *,
    assume_back: bool,
) -> WheelReadings:
    limits = limits if limits is not None else Limits.default()
    outcomes = [
        (shot, read_shot(shot, rig, survey, reference, assume_back=assume_back)) for shot in shots
    ]
    seen = [(shot, out) for shot, out in outcomes if isinstance(out, ShotReadings)]
    unmeasured = [(shot, out.reason) for shot, out in outcomes if isinstance(out, Unmeasured)]
    if not seen:
        return _nothing(unmeasured)
    readings_of = [readings for _, readings in seen]
    shot, best = min(seen, key=lambda each: _doubt(each[1]))
    joined = {quantity: _join(quantity, readings_of, reference) for quantity in Quantity}
    readings = {
        quantity: _reading(quantity, *value, limits) if value is not None else Reading.missing()
        for quantity, value in joined.items()
    }
    places = tuple(each.place for each in readings_of)
    diameter = wheel_diameter(places, survey) if survey is not None else None
    if diameter is not None:
        readings[Quantity.DIAMETER] = diameter.reading(limits)
    return WheelReadings(
        readings=readings,
        profile=_profile(best, rig, reference),
        quality=replace(
            _quality(best, rig),
            frames=tuple(_number(each) for each, _ in seen),
            best_frame=_number(shot),
            best_sensor=shot.frames[0].sensor,
            unmeasured={_number(each): reason for each, reason in unmeasured},
        ),
        reason=None,
        places=places,
        diameter=diameter,
    )


def _number(shot: Shot) -> int:
    return shot.frames[0].frame


def _nothing(unmeasured: Sequence[tuple[Shot, str]]) -> WheelReadings:
    # The shot with most points had the best chance: its reason says most.
    def points(each: tuple[Shot, str]) -> int:
        return sum(len(frame.stripe) for frame in each[0].frames)

    return WheelReadings(
        readings={quantity: Reading.missing() for quantity in Quantity},
        profile=None,
        quality=WheelQuality(unmeasured={_number(shot): reason for shot, reason in unmeasured}),
        reason=max(unmeasured, key=points)[1] if unmeasured else "no picture of this wheel",
    )


def _doubt(frame: ShotReadings) -> tuple[int, float]:
    wear = frame.values.get(Quantity.TREAD_WEAR)
    return -len(frame.values), wear.budget.sigma_mm if wear is not None else float("inf")


def _join(
    quantity: Quantity, frames: Sequence[ShotReadings], reference: ReferenceProfile
) -> tuple[float, float, Status] | None:
    """Join the values of several pictures: value, u95, status."""
    values = [frame.values[quantity] for frame in frames if quantity in frame.values]
    for status in (Status.OK, Status.EXTRAPOLATED, Status.REFERENCE_ASSUMED):
        equals = [value for value in values if value.status is status]
        if equals:
            mean, sigma = generalised_mean(equals)
            # What a measured reference may be off no number of pictures averages away.
            parts = [sigma, PICTURE_FLOOR_MM, reference.sigma_mm(quantity)]
            return mean, COVERAGE_FACTOR * float(np.hypot.reduce(parts)), status
    return None


def generalised_mean(values: Sequence[Value]) -> tuple[float, float]:
    """Return mean and sigma of values that share causes of error, by generalised least squares."""
    shared = np.stack([value.budget.shared_mm for value in values])
    single = np.array([value.budget.single_mm for value in values])
    covariance = np.diag(single**2 + PICTURE_FLOOR_MM**2) + shared @ shared.T
    weight = np.linalg.solve(covariance, np.ones(len(values)))
    weight /= weight.sum()
    variance = np.sum((weight * single) ** 2) + np.sum((weight @ shared) ** 2)
    return float(weight @ [value.value_mm for value in values]), float(np.sqrt(variance))


def _reading(
    quantity: Quantity, value: float, u95: float, status: Status, limits: Limits
) -> Reading:
    return Reading(value, u95, status, limits.judge(quantity, value, u95))


def _profile(shot: ShotReadings, rig: Rig, reference: ReferenceProfile) -> Profile:
    nodes, sigma = shot.curve.nodes_sigma()
    nominal = reference.nominal[Quantity.FLANGE_HEIGHT]
    seen_by = None
    if len(rig.sensors) > 1:
        of_part = [1 << rig.names.index(part.sensor.name) for part in shot.merged.parts]
        seen_by = shot.curve.nodes_seen_by(np.array(of_part)[shot.merged.part])
    return Profile(nodes[:, 0] - shot.back_mm, nodes[:, 1] - shot.tip_mm + nominal, sigma, seen_by)


def _quality(chosen: ShotReadings, rig: Rig) -> WheelQuality:
    merged, first = chosen.merged, chosen.merged.first
    yaw = first.sheet_yaw_rad
    left_out = Counter[Cause]()
    for part in merged.parts:
        left_out.update(part.left_out)
    return WheelQuality(
        points=len(merged.along_mm),
        left_out=dict(left_out),
        coverage=chosen.coverage,
        speckle_share=first.noise.speckle_share,
        axle_offset_mm=first.axle_offset_mm,
        sheet_yaw_deg=float(np.degrees(yaw)) if yaw is not None else None,
        wear_max_at_d_mm=chosen.wear_max_at_d_mm,
        sensors=rig.names,
        by_sensor=_shares(merged),
    )


def _shares(merged: Merged) -> dict[str, SensorShare]:
    shares = {name: SensorShare(0, reason) for name, reason in merged.silent.items()}
    for part in merged.parts:
        name = part.sensor.name
        found = merged.aside.get(name)
        shares[name] = SensorShare(
            points=len(part.along_mm),
            aside_mm=None if found is None else _pair(found.shift_mm),
            sigma_aside_mm=None if found is None else _pair(found.sigma_mm),
        )
    return shares


def _pair(values: FloatArray) -> tuple[float, float]:
    return float(values[0]), float(values[1])
