"""The gauges on a finished profile, as from a contact instrument."""

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import uniform_filter1d

from calib import FloatArray
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.gauges import Gauged, gauge
from measure.gauging.levels import EN_15313, GaugeLevels
from measure.gauging.uncertainty import Budget
from measure.limits import Limits
from measure.profile import Profile
from measure.quantities import ASSUMED_BACK_SIGMA_MM, NEEDS_BACK, Quantity, Reading, Status
from measure.reference import ReferenceProfile
from measure.wheel import WheelQuality, WheelReadings

# A profile that someone smoothed already is averaged over little more than its own points; seven
# of them at least, for a parabola.
_WINDOW_MM = 1.3
_WINDOW_STEPS = 3.0
_MIN_POINTS = 50
# Farther apart, the tip's and the throat's arcs of 12 mm are no longer followed.
_MAX_STEP_MM = 2.0
_SMOOTHING_POINTS = 9
_SIGMA_FLOOR_MM = 0.002
# Where points scatter so much more than elsewhere it is no noise: two strokes of a probe that do
# not meet, or dirt.
_LOCAL_POINTS = 15
_NO_NOISE = 3.0
# Where the rounding of the flange begins, its back is so steep that it is as good as the back.
_BACK_SEEN_MM = 0.5
_BACK_OFF_MM = 1.0
# The straight part of the back, below the tip.
_BACK_BELOW_TIP_MM = (19.0, 30.0)
_BACK_STEP_MM = 0.1


def gauge_profile(
    profile: Profile,
    reference: ReferenceProfile,
    limits: Limits | None = None,
    *,
    levels: GaugeLevels = EN_15313,
    assume_back: bool = False,
) -> WheelReadings:
    """Read all gauges off a profile.

    Parameters
    ----------
    profile
        The profile; its d = 0 is the flange back, as the instrument set it.
    reference
        The profile that wear is counted from.
    limits
        For the alarms; `Limits.default` where not given.
    levels
        Where the gauges touch, where not as EN 15313 says.
    assume_back
        Whether thickness and gradient may be read from d = 0 where no point shows the flange
        back there; they are ``missing`` otherwise, and all else is ``reference_assumed``.

    Returns
    -------
    WheelReadings
        With a reason where nothing could be read.

    Notes
    -----
    u95 counts the scatter of the points, how far the points of the flange back lie off d = 0, and
    the reference where wear is counted from a measured one: what the instrument's scale is worth
    the points do not tell.
    """
    limits = limits if limits is not None else Limits.default()
    if len(profile) < _MIN_POINTS:
        return _nothing(profile, f"{len(profile)} points, {_MIN_POINTS} needed for a profile")
    step = float(np.median(np.linalg.norm(np.diff(profile.points_mm, axis=0), axis=1)))
    if step > _MAX_STEP_MM:
        return _nothing(profile, f"points {step:.1f} mm apart, {_MAX_STEP_MM:g} needed or closer")
    back_seen = profile.d_mm.min() <= _BACK_SEEN_MM
    off_mm = _back_off_mm(profile)
    if off_mm > _BACK_OFF_MM and not assume_back:
        return _nothing(
            profile,
            f"the flange back lies {off_mm:.1f} mm off d = 0, which should be it; "
            f"{_BACK_OFF_MM:g} is allowed",
        )
    sigma = profile_sigma(profile)
    curve = curve_of(profile)
    seen = Status.OK if back_seen else Status.REFERENCE_ASSUMED
    back = Found(Estimate.exact(0.0, len(curve)), seen)
    gauged = gauge(curve, back, reference, levels)
    if gauged is None:
        return _nothing(profile, "no flange tip between d = 4 and d = 40; it is the datum of all")
    if not gauged.found:
        where = f"d = {levels.tape_d_mm:g}"
        return _nothing(profile, f"half a wheel: the tread at {where} is not seen")
    moved = gauge(curve, Found(back.estimate + _BACK_STEP_MM, seen), reference, levels)
    by_back = _by_back(gauged, moved, off_mm / np.sqrt(3.0) if back_seen else ASSUMED_BACK_SIGMA_MM)
    refused = frozenset() if back_seen or assume_back else NEEDS_BACK
    readings = {quantity: Reading.missing() for quantity in Quantity}
    for quantity, found in gauged.found.items():
        if quantity in refused:
            continue
        blind = float(np.hypot(by_back[quantity], reference.sigma_mm(quantity)))
        readings[quantity] = _reading(quantity, found, blind, sigma, limits)
    quality = WheelQuality(points=len(profile), wear_max_at_d_mm=gauged.wear_max_at_d_mm)
    return WheelReadings(readings, profile.aligned(gauged.tip_mm, reference), quality, None)


def curve_of(profile: Profile) -> Curve:
    """Return a profile as a curve that can be read anywhere along it."""
    steps = np.linalg.norm(np.diff(profile.points_mm, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    window = max(_WINDOW_MM, _WINDOW_STEPS * float(np.median(steps)))
    return Curve(profile.points_mm, along, profile_sigma(profile), window)


def profile_sigma(profile: Profile) -> FloatArray:
    """Return the sigmas of the points; where none are given, their scatter about parabolas."""
    if (profile.sigma_mm > 0.0).all():
        return profile.sigma_mm
    # Few profiles come without sigmas, and it takes all of scipy.stats along, half a second of it.
    from scipy.signal import savgol_filter  # noqa: PLC0415  see above

    rest = profile.points_mm - savgol_filter(profile.points_mm, _SMOOTHING_POINTS, 2, axis=0)
    off = np.linalg.norm(rest, axis=1)
    usual = max(1.4826 * float(np.median(off)), _SIGMA_FLOOR_MM)
    local = np.sqrt(np.maximum(uniform_filter1d(off**2, _LOCAL_POINTS), 0.0))
    return np.where(local > _NO_NOISE * usual, local, usual)


def _back_off_mm(profile: Profile) -> float:
    """Return how far the points of the flange back lie off d = 0; zero where there are none."""
    tip = int(np.argmax(profile.h_mm))
    below = profile.h_mm[tip] - profile.h_mm[:tip]
    on_back = (below > _BACK_BELOW_TIP_MM[0]) & (below < _BACK_BELOW_TIP_MM[1])
    return abs(float(np.median(profile.d_mm[:tip][on_back]))) if on_back.any() else 0.0


def _by_back(gauged: Gauged, moved: Gauged | None, sigma_mm: float) -> Mapping[Quantity, float]:
    """Return what each reading owes to a flange back that is not known better than `sigma_mm`."""
    shares = dict.fromkeys(gauged.found, 0.0)
    if moved is None:
        return shares
    for quantity, found in gauged.found.items():
        if quantity in moved.found:
            change = moved.found[quantity].estimate.value - found.estimate.value
            shares[quantity] = change / _BACK_STEP_MM * sigma_mm
    return shares


def _reading(
    quantity: Quantity, found: Found, blind_mm: float, sigma_mm: FloatArray, limits: Limits
) -> Reading:
    # The direction of the error of a point is not known: its gradient's length counts.
    noise = np.linalg.norm(found.estimate.gradient, axis=1) * sigma_mm
    single = float(np.linalg.norm([float(np.linalg.norm(noise)), found.blind_mm, blind_mm]))
    u95 = Budget(single, np.zeros(0)).u95_mm
    value = found.estimate.value
    return Reading(value, u95, found.status, limits.judge(quantity, value, u95))


def _nothing(profile: Profile, reason: str) -> WheelReadings:
    readings = {quantity: Reading.missing() for quantity in Quantity}
    return WheelReadings(readings, None, WheelQuality(points=len(profile)), reason)
