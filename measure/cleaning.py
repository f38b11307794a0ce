"""Which points of a stripe are the wheel: the others are left out, each for a cause."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from calib import BoolArray, Cause, FloatArray, IntArray, StripePoints
from measure.pieces import MIN_PIECE, pieces, sizes
from measure.template import Template

# A wheel wears inward, hardly ever outward: metal that rolls over makes a lip of a millimetre.
_OUTSIDE_MM = (-14.0, 2.5)
_BEYOND_END_MM = 1.0
_LAYER_BIN_MM = 1.0
_LAYER_GAP_MM = 0.8
_SMOOTHING_POINTS = 21
_REJECT_SIGMAS = 4.0
_GAP_MM = 2.0
_MAX_LAG = 8


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """The points of the wheel, in order, and how noisy they are.

    Attributes
    ----------
    index
        Shape (K,): which points, from the flange back to the field side.
    along_mm
        Shape (K,), rising: place along the reference.
    noise_factor
        How much more a mean of points scatters than their sigmas, taken as independent, say.
    left_out
        How many points were left out for which cause.
    """

    index: IntArray
    along_mm: FloatArray
    noise_factor: float
    left_out: Mapping[Cause, int]


def keep_wheel(
    points_mm: FloatArray, sigma_mm: FloatArray, stripe: StripePoints, template: Template
) -> Kept:
    """Keep the points that make one profile near the reference.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (y, z): already laid over the reference by the flange.
    sigma_mm
        Shape (N,), across the profile.
    stripe
        The same points in the picture.
    template
        The reference.

    Returns
    -------
    Kept
        Perhaps of no points.
    """
    along, outside, nearest = template.place(points_mm)
    in_band = np.flatnonzero(_can_be_wheel(along, outside, nearest, template))
    piece = pieces(stripe.centre_px[in_band], stripe.normal[in_band])
    large = sizes(piece) >= MIN_PIECE
    hanging, piece = in_band[large], piece[large]
    first = hanging[_first_layer(along[hanging], outside[hanging], piece)]
    ordered = first[np.argsort(along[first], kind="stable")]

    score = _misfit(along[ordered], outside[ordered], sigma_mm[ordered])
    spread = max(1.0, _robust_sigma(score))
    inlier = np.abs(score) <= _REJECT_SIGMAS * spread
    left_out = {
        Cause.STRAY_LIGHT: len(points_mm) - len(hanging),
        Cause.GLARE: len(hanging) - len(ordered),
        Cause.OUTLIER: int(np.sum(~inlier)),
    }
    return Kept(
        index=ordered[inlier],
        along_mm=along[ordered[inlier]],
        noise_factor=float(spread * np.sqrt(_correlation_length(score[inlier]))),
        left_out={cause: count for cause, count in left_out.items() if count},
    )


def _can_be_wheel(
    along_mm: FloatArray, outside_mm: FloatArray, nearest: IntArray, template: Template
) -> BoolArray:
    low, high = _OUTSIDE_MM
    on_profile = along_mm < template.along_mm[-1] + _BEYOND_END_MM
    # The back face does not wear: what lies behind it is something else.
    floor = np.where(nearest < template.back_count, -high, low)
    return np.asarray((outside_mm > floor) & (outside_mm < high) & on_profile)


def _first_layer(along_mm: FloatArray, outside_mm: FloatArray, piece: IntArray) -> BoolArray:
    """Where two pieces lie over one another, keep the larger: the other is its reflection."""
    keep = np.ones(len(piece), dtype=bool)
    if not piece.any():  # One piece has no other to lie over.
        return keep
    bins = np.floor(along_mm / _LAYER_BIN_MM).astype(np.int64)
    taken: dict[int, float] = {}
    for number in np.argsort(-np.bincount(piece)):
        members = np.flatnonzero(piece == number)
        for place in np.unique(bins[members]):
            here = members[bins[members] == place]
            height = float(np.median(outside_mm[here]))
            if abs(height - taken.setdefault(int(place), height)) > _LAYER_GAP_MM:
                keep[here] = False
    return keep


def _misfit(along_mm: FloatArray, outside_mm: FloatArray, sigma_mm: FloatArray) -> FloatArray:
    """Return how many sigmas each point lies off its smoothed neighbours."""
    score = np.zeros(len(along_mm))
    breaks = np.flatnonzero(np.diff(along_mm) > _GAP_MM) + 1
    for run in np.split(np.arange(len(along_mm)), breaks):
        if len(run) < _SMOOTHING_POINTS:
            continue
        height = outside_mm[run]
        # A parabola through points that hold a gross error bends towards it: medians first.
        rough = height - median_filter(height, 9, mode="nearest")
        gross = np.abs(rough) > 6.0 * max(_robust_sigma(rough), 1e-6)
        steady = np.where(gross, height - rough, height)
        score[run] = (height - savgol_filter(steady, _SMOOTHING_POINTS, 2)) / sigma_mm[run]
    # The point itself takes part in its parabola: 9 / 4K of its error is hidden there.
    return np.asarray(score / np.sqrt(1.0 - 9.0 / (4.0 * _SMOOTHING_POINTS)))


def _robust_sigma(values: FloatArray) -> float:
    return float(1.4826 * np.median(np.abs(values))) if len(values) else 0.0


def _correlation_length(score: FloatArray) -> float:
    """Return how many neighbours count as one: 1 + 2 (sum of the correlations that are there)."""
    power = float(np.mean(score**2)) if len(score) > 4 * _MAX_LAG else 0.0
    if not power > 0.0:
        return 1.0
    length = 1.0
    # A parabola through K points leaves the residuals of white noise a correlation of -9 / 4K.
    expected = -9.0 / (4.0 * _SMOOTHING_POINTS)
    for lag in range(1, _MAX_LAG + 1):
        correlation = float(np.mean(score[lag:] * score[:-lag])) / power - expected
        if correlation < 3.0 / np.sqrt(len(score)):
            break
        length += 2.0 * correlation
    return length
