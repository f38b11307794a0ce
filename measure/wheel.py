"""A wheel from the pictures of it: readings with uncertainty, status and alarm."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from calib import Cause, LaserSensor, StripePoints
from measure.frame import FrameReadings, Value, measure_frame
from measure.gauging.uncertainty import COVERAGE_FACTOR, PICTURE_FLOOR_MM
from measure.laying.by_axle import Unmeasured
from measure.limits import Limits
from measure.mounting import Mounting
from measure.profile import Profile
from measure.quantities import Quantity, Reading, Status
from measure.reference import ReferenceProfile


@dataclass(frozen=True, slots=True, eq=False)
class WheelFrame:
    """The stripe of one picture, and which picture it was."""

    stripe: StripePoints
    frame: int
    source: str
    time_ns: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class WheelQuality:
    """What stands behind the readings of a wheel.

    Attributes
    ----------
    frames
        Frames that gave readings.
    best_frame
        The one that carried most weight; the profile is its.
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
    """

    frames: tuple[int, ...] = ()
    best_frame: int | None = None
    points: int = 0
    left_out: Mapping[Cause, int] = field(default_factory=dict)
    coverage: float = 0.0
    speckle_share: float | None = None
    axle_offset_mm: float | None = None
    sheet_yaw_deg: float | None = None
    wear_max_at_d_mm: float | None = None
    unmeasured: Mapping[int, str] = field(default_factory=dict)


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
    """

    readings: Mapping[Quantity, Reading]
    profile: Profile | None
    quality: WheelQuality
    reason: str | None

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
        The survey of the installation. Without it the cut is taken for radial and turned until
        it fits the reference, and every status is ``reference_assumed``.
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
    limits = limits if limits is not None else Limits.default()
    outcomes = {
        frame.frame: measure_frame(
            frame.stripe, sensor, reference, mounting, assume_back=assume_back
        )
        for frame in frames
    }
    seen = {n: out for n, out in outcomes.items() if isinstance(out, FrameReadings)}
    unmeasured = {n: out.reason for n, out in outcomes.items() if isinstance(out, Unmeasured)}
    if not seen:
        return _nothing(frames, unmeasured)
    best = min(seen, key=lambda number: _doubt(seen[number]))
    joined = {quantity: _join(quantity, list(seen.values()), reference) for quantity in Quantity}
    readings = {
        quantity: _reading(quantity, *value, limits) if value is not None else Reading.missing()
        for quantity, value in joined.items()
    }
    return WheelReadings(
        readings=readings,
        profile=_profile(seen[best], reference),
        quality=_quality(seen, best, unmeasured),
        reason=None,
    )


def _nothing(frames: Sequence[WheelFrame], unmeasured: Mapping[int, str]) -> WheelReadings:
    # The frame with most points had the best chance: its reason says most.
    fullest = max(frames, key=lambda frame: len(frame.stripe), default=None)
    reason = unmeasured[fullest.frame] if fullest is not None else "no picture of this wheel"
    return WheelReadings(
        readings={quantity: Reading.missing() for quantity in Quantity},
        profile=None,
        quality=WheelQuality(unmeasured=unmeasured),
        reason=reason,
    )


def _doubt(frame: FrameReadings) -> tuple[int, float]:
    wear = frame.values.get(Quantity.TREAD_WEAR)
    return -len(frame.values), wear.budget.sigma_mm if wear is not None else float("inf")


def _join(
    quantity: Quantity, frames: Sequence[FrameReadings], reference: ReferenceProfile
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


def _profile(frame: FrameReadings, reference: ReferenceProfile) -> Profile:
    nodes, sigma = frame.curve.nodes_sigma()
    nominal = reference.nominal[Quantity.FLANGE_HEIGHT]
    return Profile(nodes[:, 0] - frame.back_mm, nodes[:, 1] - frame.tip_mm + nominal, sigma)


def _quality(
    seen: Mapping[int, FrameReadings], best: int, unmeasured: Mapping[int, str]
) -> WheelQuality:
    chosen = seen[best]
    laid = chosen.laid
    yaw = laid.sheet_yaw_rad
    return WheelQuality(
        frames=tuple(seen),
        best_frame=best,
        points=len(laid.along_mm),
        left_out=laid.left_out,
        coverage=chosen.coverage,
        speckle_share=laid.noise.speckle_share,
        axle_offset_mm=laid.axle_offset_mm,
        sheet_yaw_deg=float(np.degrees(yaw)) if yaw is not None else None,
        wear_max_at_d_mm=chosen.wear_max_at_d_mm,
        unmeasured=unmeasured,
    )
