"""The gauges on a finished profile, as from a contact instrument."""

import numpy as np
from scipy.signal import savgol_filter

from calib import FloatArray
from measure.curve import Curve, Found
from measure.estimate import Estimate
from measure.gauges import Gauged, gauge
from measure.limits import Limits
from measure.profile import Profile
from measure.quantities import Quantity, Reading, Status
from measure.reference import ReferenceProfile
from measure.uncertainty import Budget
from measure.wheel import WheelQuality, WheelReadings

# A profile that someone smoothed already is averaged over little more than its own points.
_WINDOW_MM = 1.3
_MIN_POINTS = 50
_SMOOTHING_POINTS = 9
_SIGMA_FLOOR_MM = 0.002


def gauge_profile(
    profile: Profile, reference: ReferenceProfile, limits: Limits | None = None
) -> WheelReadings:
    """Read all gauges off a profile.

    Parameters
    ----------
    profile
        The profile; its d = 0 is taken for the flange back, as the instrument set it.
    reference
        The profile that wear is counted from.
    limits
        For the alarms; `Limits.default` where not given.

    Returns
    -------
    WheelReadings
        With a reason where nothing could be read.

    Notes
    -----
    u95 counts the scatter of the points alone: what the instrument's datum and scale are worth
    the points do not tell.
    """
    limits = limits if limits is not None else Limits.default()
    if len(profile) < _MIN_POINTS:
        return _nothing(profile, f"{len(profile)} points, {_MIN_POINTS} needed for a profile")
    sigma = _sigma(profile)
    curve = Curve(profile.points_mm, _path_length(profile.points_mm), sigma, _WINDOW_MM)
    back = Found(Estimate.exact(0.0, len(curve)), Status.OK)
    gauged = gauge(curve, back, reference)
    if gauged is None:
        return _nothing(profile, "no flange tip between d = 4 and d = 40; it is the datum of all")
    if not gauged.found:
        return _nothing(profile, "half a wheel: the tread at d = 70 is not seen")
    readings = {quantity: Reading.missing() for quantity in Quantity}
    readings |= _readings(gauged, sigma, limits)
    quality = WheelQuality(points=len(profile), wear_max_at_d_mm=gauged.wear_max_at_d_mm)
    return WheelReadings(readings, profile, quality, None)


def _readings(gauged: Gauged, sigma_mm: FloatArray, limits: Limits) -> dict[Quantity, Reading]:
    readings = {}
    for quantity, found in gauged.found.items():
        # The direction of the error of a point is not known: its gradient's length counts.
        noise = np.linalg.norm(found.estimate.gradient, axis=1) * sigma_mm
        u95 = Budget(float(np.hypot(np.linalg.norm(noise), found.blind_mm)), np.zeros(0)).u95_mm
        value = found.estimate.value
        readings[quantity] = Reading(value, u95, found.status, limits.judge(quantity, value, u95))
    return readings


def _nothing(profile: Profile, reason: str) -> WheelReadings:
    readings = {quantity: Reading.missing() for quantity in Quantity}
    return WheelReadings(readings, None, WheelQuality(points=len(profile)), reason)


def _path_length(points_mm: FloatArray) -> FloatArray:
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _sigma(profile: Profile) -> FloatArray:
    """Return the sigmas of the points; where none are given, their scatter about a parabola."""
    if (profile.sigma_mm > 0.0).all():
        return profile.sigma_mm
    rest = profile.points_mm - savgol_filter(profile.points_mm, _SMOOTHING_POINTS, 2, axis=0)
    scatter = 1.4826 * float(np.median(np.linalg.norm(rest, axis=1)))
    return np.full(len(profile), max(scatter, _SIGMA_FLOOR_MM))
