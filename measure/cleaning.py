"""Which points of a stripe are the wheel: the others are left out, each for a cause."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from calib import BoolArray, Cause, FloatArray, IntArray
from measure.template import Template

# A wheel wears inward, hardly ever outward: metal that rolls over makes a lip of a millimetre.
_OUTSIDE_MM = (-14.0, 2.5)
_LINK_PX = 4.0
_LINK_MM = 4.0
_MIN_PIECE = 12
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
    causes
        N entries: why a point was left out; ``Cause.NONE`` for the kept.
    """

    index: IntArray
    along_mm: FloatArray
    noise_factor: float
    causes: tuple[Cause, ...]


def keep_wheel(
    points_mm: FloatArray, sigma_mm: FloatArray, centre_px: FloatArray, template: Template
) -> Kept:
    """Keep the points that make one connected profile near the reference.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (y, z): already laid over the reference by the flange.
    sigma_mm
        Shape (N,), across the profile.
    centre_px
        Shape (N, 2), in the picture: neighbours there are neighbours on the stripe.
    template
        The reference.

    Returns
    -------
    Kept
        Perhaps of no points.
    """
    along, outside, nearest = template.place(points_mm)
    causes = [Cause.NONE] * len(points_mm)

    def leave_out(index: IntArray, cause: Cause) -> None:
        for point in index:
            causes[point] = cause

    beyond = along > template.along_mm[-1] + 1.0
    in_band = (outside > _OUTSIDE_MM[0]) & (outside < _OUTSIDE_MM[1]) & ~beyond
    # The back face does not wear: what lies off it is something else.
    on_back = nearest < template.back_count
    in_band &= ~(on_back & (np.abs(outside) > _OUTSIDE_MM[1]))
    leave_out(np.flatnonzero(~in_band), Cause.STRAY_LIGHT)
    kept = np.flatnonzero(in_band)
    piece = _pieces(points_mm[kept], centre_px[kept])
    size = np.bincount(piece)[piece] if len(kept) else np.zeros(0, dtype=np.int64)
    leave_out(kept[size < _MIN_PIECE], Cause.STRAY_LIGHT)
    kept, piece = kept[size >= _MIN_PIECE], piece[size >= _MIN_PIECE]

    first_layer = _first_layer(along[kept], outside[kept], piece)
    leave_out(kept[~first_layer], Cause.GLARE)
    kept = kept[first_layer]
    kept = kept[np.argsort(along[kept], kind="stable")]

    score = _misfit(along[kept], outside[kept], sigma_mm[kept])
    spread = max(1.0, _robust_sigma(score))
    inlier = np.abs(score) <= _REJECT_SIGMAS * spread
    leave_out(kept[~inlier], Cause.OUTLIER)
    kept, score = kept[inlier], score[inlier]
    factor = spread * np.sqrt(_correlation_length(score))
    return Kept(kept, _rising(along[kept]), float(factor), tuple(causes))


def _pieces(points_mm: FloatArray, centre_px: FloatArray) -> IntArray:
    """Return the number of the piece, of stripe that hang together in the picture and in the section."""
    if not len(points_mm):
        return np.zeros(0, dtype=np.int64)
    pairs = cKDTree(centre_px).query_pairs(_LINK_PX, output_type="ndarray")
    gap = np.linalg.norm(points_mm[pairs[:, 0]] - points_mm[pairs[:, 1]], axis=1)
    i, j = pairs[gap <= _LINK_MM].T
    links = coo_array((np.ones(len(i)), (i, j)), shape=(len(points_mm), len(points_mm)))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


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


def _rising(along_mm: FloatArray) -> FloatArray:
    return np.asarray(np.maximum.accumulate(along_mm)) if len(along_mm) else along_mm
