"""The gauges: what EN 15313 and the type-4 wheel gauge read, taken off a measured curve."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.levels import EN_15313, TAPE_D_MM, GaugeLevels
from measure.quantities import Quantity, Status
from measure.reference import ReferenceProfile

_TIP_D_MM = (4.0, 40.0)
_TREAD_WINDOW = 2.0
# The running tread, clear of the throat and of the chamfer.
_TREAD_D_MM = (56.0, 118.0)
_HOLLOW_D_MM = (56.0, 126.0)
_MIN_TREAD_SHARE = 0.7
_TREAD_SMOOTHING_MM = 5.0
# The place of the greatest wear is sought on a smoother tread than its depth is read off: of many
# places the one is taken else whose noise makes it deepest.
_WEAR_SMOOTHING_MM = 8.0
# A hollow's low and high place are farther apart: what rises over less is noise.
_HOLLOW_LENGTH_MM = 5.0

_ORDER = (Status.OK, Status.EXTRAPOLATED, Status.REFERENCE_ASSUMED, Status.MISSING)


@dataclass(frozen=True, slots=True, eq=False)
class Gauged:
    """What was read off one curve.

    Attributes
    ----------
    found
        The readings that could be taken.
    tip_mm
        Height r of the flange tip; the vertical datum.
    wear_max_at_d_mm
        Where the greatest tread wear is.
    """

    found: Mapping[Quantity, Found]
    tip_mm: float
    wear_max_at_d_mm: float | None


def gauge(
    curve: Curve,
    back: Found,
    reference: ReferenceProfile,
    levels: GaugeLevels = EN_15313,
) -> Gauged | None:
    """Read all gauges off a curve.

    Parameters
    ----------
    curve
        The measured profile.
    back
        Lateral place a of the flange back: d = a - back. Where it is not seen but assumed from
        the reference, its status says so, and with it that of every reading.
    reference
        What wear is counted from.
    levels
        Where flange height, thickness and gradient are taken, where not as EN 15313 says.

    Returns
    -------
    Gauged or None
        None where no flange tip is seen: it is the datum of all.
    """
    nodes = curve.nodes()
    crest = curve.crest(_highest(nodes, back.estimate.value))
    if crest is None:
        return None
    tip = crest
    readings = _flange_readings(curve, nodes, back, tip, levels)
    if Quantity.FLANGE_HEIGHT in readings:
        height = readings[Quantity.FLANGE_HEIGHT]
        readings[Quantity.TREAD_WEAR] = _wear(height, levels.tape_d_mm, reference)
        # Aligned at back and tip, the height lost at d = 70 is the loss of the Sh taken there.
        drop = (
            height
            if levels.tape_d_mm == TAPE_D_MM
            else _drop_to(TAPE_D_MM, curve, nodes, back, tip)
        )
        if drop is not None:
            readings[Quantity.TREAD_WEAR_AT_70] = _wear(drop, TAPE_D_MM, reference)
    wear_max, at_d = _greatest_wear(curve, nodes, back, tip, reference)
    hollow = _hollow(curve, nodes, back)
    optional = {Quantity.TREAD_WEAR_MAX: wear_max, Quantity.HOLLOW_DEPTH: hollow}
    readings |= {quantity: found for quantity, found in optional.items() if found is not None}
    return Gauged(readings, tip.estimate.value, at_d)


def _flange_readings(
    curve: Curve, nodes: FloatArray, back: Found, tip: Found, levels: GaugeLevels
) -> dict[Quantity, Found]:
    tread = _height_at(curve, nodes, back.estimate + levels.tape_d_mm)
    if tread is None:
        return {}
    level = tread.estimate
    readings = {Quantity.FLANGE_HEIGHT: _combined(tip.estimate - level, tip, tread, back)}
    lower = _face_at(curve, nodes, level + levels.face_mm, tip.estimate.value)
    face_12 = _face_at(curve, nodes, level + 12.0, tip.estimate.value)
    near_tip = _face_at(curve, nodes, tip.estimate - levels.below_tip_mm, tip.estimate.value)
    for quantity, face in (
        (Quantity.FLANGE_THICKNESS_10, lower),
        (Quantity.FLANGE_THICKNESS_12, face_12),
    ):
        if face is not None:
            thickness = face.estimate - back.estimate
            readings[quantity] = _combined(thickness, face, tread, back)
    if lower is not None and near_tip is not None:
        gradient = lower.estimate - near_tip.estimate
        readings[Quantity.FLANGE_GRADIENT_QR] = _combined(gradient, lower, near_tip, tread, back)
    return readings


def _combined(estimate: Estimate, *parts: Found) -> Found:
    status = max((part.status for part in parts), key=_ORDER.index)
    return Found(estimate, status, float(np.hypot.reduce([part.blind_mm for part in parts])))


def _highest(nodes: FloatArray, back_mm: float) -> FloatArray:
    d = nodes[:, 0] - back_mm
    candidates = nodes[(d >= _TIP_D_MM[0]) & (d <= _TIP_D_MM[1])]
    pool = candidates if len(candidates) else nodes
    return np.asarray(pool[np.argmax(pool[:, 1])])


def _height_at(
    curve: Curve, nodes: FloatArray, place: Estimate, scale: float = _TREAD_WINDOW
) -> Found | None:
    tip = int(np.argmax(nodes[:, 1]))
    field = nodes[tip:]
    if not len(field):
        return None
    start = field[np.argmin(np.abs(field[:, 0] - place.value))]
    return curve.read(1, place, start, scale)


def _face_at(curve: Curve, nodes: FloatArray, level: Estimate, tip_mm: float) -> Found | None:
    """Read where the flange face, the first descent beyond the tip, takes a level."""
    tip = int(np.argmin(np.abs(nodes[:, 1] - tip_mm)))
    below = np.flatnonzero(nodes[tip:, 1] <= level.value)
    if not len(below):
        return None
    after = tip + int(below[0])
    before = max(after - 1, 0)
    share = (nodes[before, 1] - level.value) / max(nodes[before, 1] - nodes[after, 1], 1e-9)
    start = nodes[before] + np.clip(share, 0.0, 1.0) * (nodes[after] - nodes[before])
    return curve.read(0, level, start)


def _greatest_wear(
    curve: Curve, nodes: FloatArray, back: Found, tip: Found, reference: ReferenceProfile
) -> tuple[Found | None, float | None]:
    """Read the wear where the smoothed tread lies deepest below the reference."""
    # What is smoothed is the wear: the tread itself bends towards the throat.
    outside = nodes[:, 1] - reference.height_mm(nodes[:, 0] - back.estimate.value - TAPE_D_MM)
    tread = _tread(nodes, outside, back, _TREAD_D_MM, _WEAR_SMOOTHING_MM)
    if tread is None:
        return None, None
    d, over_reference = tread
    at_d = float(d[np.argmin(over_reference)])
    drop = _drop_to(at_d, curve, nodes, back, tip)
    return (_wear(drop, at_d, reference), at_d) if drop is not None else (None, None)


def _drop_to(d_mm: float, curve: Curve, nodes: FloatArray, back: Found, tip: Found) -> Found | None:
    """Return how far the tread lies below the tip at a place."""
    height = _height_at(curve, nodes, back.estimate + d_mm)
    return (
        _combined(tip.estimate - height.estimate, tip, height, back) if height is not None else None
    )


def _wear(drop: Found, d_mm: float, reference: ReferenceProfile) -> Found:
    """Return by how much a drop from the tip at a place exceeds the reference's."""
    nominal = reference.nominal[Quantity.FLANGE_HEIGHT]
    surplus = float(reference.height_mm(d_mm - TAPE_D_MM)) - nominal
    return replace(drop, estimate=drop.estimate + surplus)


def _hollow(curve: Curve, nodes: FloatArray, back: Found) -> Found | None:
    """Read how far the tread lies below the highest place on its field side."""
    tread = _tread(nodes, nodes[:, 1], back, _HOLLOW_D_MM, _TREAD_SMOOTHING_MM)
    if tread is None:
        return None
    d, r = tread
    apart = int(np.searchsorted(d, d[0] + _HOLLOW_LENGTH_MM))
    if not len(d) > apart:
        return None
    high = apart + int(np.argmax(r[apart:] - np.minimum.accumulate(r)[:-apart]))
    low = int(np.argmin(r[: high - apart + 1]))
    places = [back.estimate + float(d[at]) for at in (high, low)]
    top, bottom = (_height_at(curve, nodes, place) for place in places)
    if top is None or bottom is None:
        return None
    depth = top.estimate - bottom.estimate
    # Where a tread is highest it often breaks (1:40 to 1:15 in LMA), and a parabola rounds that
    # off: by how much, one of half the width tells, though with more noise.
    narrow = [_height_at(curve, nodes, place, _TREAD_WINDOW / 2.0) for place in places]
    heights = [found.estimate.value for found in narrow if found is not None]
    rounded = heights[0] - heights[1] - depth.value if len(heights) == len(places) else 0.0
    if not depth.value > 0.0:  # It falls all the way to the field side, as a new one does.
        depth, rounded = Estimate(0.0, depth.gradient), 0.0
    found = _combined(depth, top, bottom, back)
    return replace(found, blind_mm=float(np.hypot(found.blind_mm, rounded)))


def _tread(
    nodes: FloatArray,
    height_mm: FloatArray,
    back: Found,
    span_d_mm: tuple[float, float],
    smoothing_mm: float,
) -> tuple[FloatArray, FloatArray] | None:
    """Return d and smoothed height of the tread, every millimetre of a span.

    `height_mm` is that of each node over anything smooth; None is where too much hides.
    """
    d_nodes = nodes[:, 0] - back.estimate.value
    on_tread = (d_nodes > TAPE_D_MM - 20.0) & (nodes[:, 1] < nodes[:, 1].max() - 14.0)
    # Beyond the span lie throat and chamfer: no mean of the tread may take them in.
    on_tread &= np.isfinite(height_mm) & (d_nodes >= span_d_mm[0]) & (d_nodes <= span_d_mm[1])
    d_seen, seen_mm = d_nodes[on_tread], height_mm[on_tread]
    d = np.arange(span_d_mm[0], span_d_mm[1] + 0.5)
    beside = d_seen - d[:, None]
    near = (np.abs(beside) <= smoothing_mm).astype(np.float64)
    seen = near.sum(axis=1) >= 3.0
    if not seen.mean() >= _MIN_TREAD_SHARE:
        return None
    # Lines, not means: at the ends of the span all neighbours lie on one side.
    near, beside = near[seen], beside[seen] * near[seen]
    count, first, second = near.sum(axis=1), beside.sum(axis=1), (beside**2).sum(axis=1)
    sloped = second * (near @ seen_mm) - first * (beside @ seen_mm)
    return d[seen], sloped / (count * second - first**2)
