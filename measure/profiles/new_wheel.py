"""New wheels that were measured, made into the profile that wear is counted from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import stdtrit

from calib import FloatArray
from measure.analytic_references import reference_profile
from measure.errors import ReferenceInvalid
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.gauges import gauge
from measure.gauging.levels import TAPE_D_MM
from measure.gauging.uncertainty import COVERAGE_FACTOR
from measure.profile import Profile
from measure.profiles.gauged import curve_of, profile_sigma
from measure.quantities import Quantity, Reading, Status
from measure.reference import ReferenceProfile

REFERENCE_STEP_MM = 0.25
"""Distance of a reference's points: its chords lie 0.7 um below an arc of 12 mm at most."""
REFERENCE_WINDOW_MM = 3.0
"""Half-width of the pieces that are smoothed, as a wheel's own readings are."""
NOMINAL = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
)
"""What is known of a reference as numbers."""
_WIDEST_GAP_MM = 4.0
_NEAR_MM = 2.0
# Wheels of one drawing are turned to half a millimetre; what differs by more is worn, or another.
_ONE_DRAWING_MM = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class NewWheel:
    """One measurement of a new wheel: its profile, and what was read on it."""

    profile: Profile
    readings: Mapping[Quantity, Reading]


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredReference:
    """A reference that was measured.

    Attributes
    ----------
    points_mm
        Shape (N, 2), (y, z), smoothed, evenly spaced, z = 0 on the tape circle.
    sigma_mm
        Shape (N,), standard deviation across the profile.
    nominal, u95
        What the gauges read on it, mm, mean over the wheels, and its 95 % uncertainty.
    spread
        Standard deviation from wheel to wheel, mm; empty of a single one.
    """

    points_mm: FloatArray
    sigma_mm: FloatArray
    nominal: Mapping[Quantity, float]
    u95: Mapping[Quantity, float]
    spread: Mapping[Quantity, float] = field(default_factory=dict)

    def profile(self, name: str) -> ReferenceProfile:
        """Return it as what wear is counted from."""
        sigma = self.u95[Quantity.FLANGE_HEIGHT] / COVERAGE_FACTOR
        return ReferenceProfile.measured(name, self.points_mm, self.nominal, sigma)


def reference_of_new_wheels(wheels: Sequence[NewWheel]) -> MeasuredReference:
    r"""Make a reference of one or more measurements of new wheels.

    Parameters
    ----------
    wheels
        Each seen from its flange back to the field side, every nominal reading ``ok``: a wheel
        that was itself laid over a reference is no measurement of its shape.

    Raises
    ------
    ReferenceInvalid
        If there is no wheel, one is incomplete, or they are not wheels of one drawing.

    Notes
    -----
    The noise of a reference would enter every wear. Twice, if its own Sh were read off its points
    once more: the readings are therefore taken over, and the points, which only say how wear is
    spread over the tread, are smoothed by local parabolas of half-width 3 mm (bias 0.5 um on
    R = 12 mm) and thinned to 0.25 mm.

    What cannot be smoothed away stays in u95. Of n wheels measured alike it is

    .. math:: u_{95}^2 = \bar u_{95}^2 + (t_{0.975, n-1} s / \sqrt n)^2

    as calibration and survey are shared by all, and the scatter s is averaged. Wear that the same
    sensor measures later owes less to its calibration than this says: the two errors are alike.
    """
    if not wheels:
        raise ReferenceInvalid("no new wheel; one or more are needed")
    for place, wheel in enumerate(wheels, start=1):
        _check_readings(wheel, f"wheel {place} of {len(wheels)}")
    nominal, u95, spread = _means(wheels)
    smoothed = [_smoothed(wheel.profile) for wheel in wheels]
    points, sigma = _mean_profile(smoothed)
    height = nominal[Quantity.FLANGE_HEIGHT]
    return MeasuredReference(points + [-TAPE_D_MM, height], sigma, nominal, u95, spread)


def _check_readings(wheel: NewWheel, which: str) -> None:
    for quantity in NOMINAL:
        status = wheel.readings[quantity].status
        if status is not Status.OK:
            raise ReferenceInvalid(
                f"{which}: {quantity.value} is {status.value}; a reference needs it measured (ok), "
                "by a surveyed sensor that sees from the flange back to the field side"
            )


def _means(
    wheels: Sequence[NewWheel],
) -> tuple[dict[Quantity, float], dict[Quantity, float], dict[Quantity, float]]:
    count = len(wheels)
    nominal, u95, spread = {}, {}, {}
    for quantity in NOMINAL:
        read = [wheel.readings[quantity] for wheel in wheels]
        values = np.array([reading.value for reading in read], dtype=np.float64)
        own = np.array([reading.u95 for reading in read], dtype=np.float64)
        nominal[quantity], u95[quantity] = float(values.mean()), float(own.mean())
        if np.ptp(values) > _ONE_DRAWING_MM:
            raise ReferenceInvalid(
                f"{quantity.value} runs from {values.min():.2f} to {values.max():.2f} mm; new "
                f"wheels of one drawing are within {_ONE_DRAWING_MM:g}: leave out what is worn"
            )
        if count > 1:
            spread[quantity] = float(values.std(ddof=1))
            of_mean = float(stdtrit(count - 1, 0.975)) * spread[quantity] / np.sqrt(count)
            u95[quantity] = float(np.hypot(u95[quantity], of_mean))
    return nominal, u95, spread


def _smoothed(profile: Profile) -> tuple[FloatArray, FloatArray]:
    """Return points (d, height over the tip) evenly along a profile, smoothed, and their sigmas."""
    narrow = curve_of(profile)
    steps = np.diff(narrow.along_mm)
    if steps.max() > _WIDEST_GAP_MM:
        at = int(np.argmax(steps))
        raise ReferenceInvalid(
            f"a gap of {steps[at]:.1f} mm at d = {profile.d_mm[at]:.1f}; a reference may have "
            f"{_WIDEST_GAP_MM:g}"
        )
    # The gauges count wear from something; only the tip is asked of them here.
    back = Found(Estimate.exact(0.0, len(narrow)), Status.OK)
    found = gauge(narrow, back, reference_profile("S1002"))
    if found is None:
        raise ReferenceInvalid("no flange tip between d = 4 and d = 40")
    curve = Curve(profile.points_mm, narrow.along_mm, profile_sigma(profile), REFERENCE_WINDOW_MM)
    along = np.arange(0.0, curve.along_mm[-1], REFERENCE_STEP_MM)
    places = np.column_stack([
        np.interp(along, curve.along_mm, column) for column in curve.points_mm.T
    ])
    smooth = [found_at for place in places if (found_at := _smooth_at(curve, place)) is not None]
    points, sigma = np.array([p for p, _ in smooth]), np.array([s for _, s in smooth])
    return points - [0.0, found.tip_mm], sigma


def _smooth_at(curve: Curve, place_mm: FloatArray) -> tuple[FloatArray, float] | None:
    fit = curve.fit(place_mm)
    if fit is None:
        return None
    s = float((place_mm - fit.origin_mm) @ fit.tangent)
    if not fit.covers(s):
        return None
    hat = np.array([1.0, s, s * s]) @ fit.solver
    return fit.point(s), float(np.sqrt(hat**2 @ curve.sigma_mm[fit.index] ** 2))


def _mean_profile(
    smoothed: Sequence[tuple[FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    """Average profiles across themselves: along its normal, each point of the first is moved."""
    base, own = smoothed[0]
    if len(smoothed) == 1:
        return base, own
    tangent = np.gradient(base, axis=0)
    normal = tangent[:, ::-1] * [-1.0, 1.0] / np.linalg.norm(tangent, axis=1)[:, None]
    offsets, variances = [np.zeros(len(base))], [own**2]
    for points, sigma in smoothed[1:]:
        away, nearest = cKDTree(points).query(base)
        offset = np.sum((points[nearest] - base) * normal, axis=1)
        offsets.append(np.where(away < _NEAR_MM, offset, np.nan))
        variances.append(np.where(away < _NEAR_MM, sigma[nearest] ** 2, np.nan))
    count = np.isfinite(offsets).sum(axis=0)
    mean = np.nanmean(offsets, axis=0)
    scatter = np.nansum((np.array(offsets) - mean) ** 2, axis=0) / np.maximum(count - 1, 1)
    noise = np.nanmean(variances, axis=0)
    return base + mean[:, None] * normal, np.sqrt(np.maximum(scatter, noise) / count)
