"""The gauges: what EN 15313 and the type-4 wheel gauge read, taken off a measured curve."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray
from measure.curve import Curve, Found
from measure.estimate import Estimate
from measure.quantities import Quantity, Status
from measure.reference import ReferenceProfile

TAPE_D_MM = 70.0
"""Distance of the tape circle from the flange back."""
_TIP_D_MM = (4.0, 40.0)
_TREAD_WINDOW = 1.5
# The running tread, clear of the throat and of the chamfer.
_TREAD_D_MM = (56.0, 118.0)
_HOLLOW_D_MM = (56.0, 126.0)
_MIN_TREAD_SHARE = 0.7
_TREAD_SMOOTHING_MM = 2.5

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


def gauge(curve: Curve, back: Found, reference: ReferenceProfile) -> Gauged | None:
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
    readings = _flange_readings(curve, nodes, back, tip)
    if Quantity.FLANGE_HEIGHT in readings:
        height = readings[Quantity.FLANGE_HEIGHT]
        nominal = reference.nominal[Quantity.FLANGE_HEIGHT]
        wear = replace(height, estimate=height.estimate - nominal)
        # Aligned at back and tip, the height lost at d = 70 is the loss of Sh (wheel.md's words
        # for it differ by trade, the number does not).
        readings |= {Quantity.TREAD_WEAR: wear, Quantity.TREAD_WEAR_AT_70: wear}
    wear_max, at_d = _greatest_wear(curve, nodes, back, tip, reference)
    hollow = _hollow(curve, nodes, back)
    optional = {Quantity.TREAD_WEAR_MAX: wear_max, Quantity.HOLLOW_DEPTH: hollow}
    readings |= {quantity: found for quantity, found in optional.items() if found is not None}
    return Gauged(readings, tip.estimate.value, at_d)


def _flange_readings(
    curve: Curve, nodes: FloatArray, back: Found, tip: Found
) -> dict[Quantity, Found]:
    tread = _height_at(curve, nodes, back.estimate + TAPE_D_MM)
    if tread is None:
        return {}
    level = tread.estimate
    readings = {Quantity.FLANGE_HEIGHT: _combined(tip.estimate - level, tip, tread, back)}
    face_10 = _face_at(curve, nodes, level + 10.0, tip.estimate.value)
    face_12 = _face_at(curve, nodes, level + 12.0, tip.estimate.value)
    near_tip = _face_at(curve, nodes, tip.estimate - 2.0, tip.estimate.value)
    for quantity, face in (
        (Quantity.FLANGE_THICKNESS_10, face_10),
        (Quantity.FLANGE_THICKNESS_12, face_12),
    ):
        if face is not None:
            thickness = face.estimate - back.estimate
            readings[quantity] = _combined(thickness, face, tread, back)
    if face_10 is not None and near_tip is not None:
        gradient = face_10.estimate - near_tip.estimate
        readings[Quantity.FLANGE_GRADIENT_QR] = _combined(gradient, face_10, near_tip, tread, back)
    return readings


def _combined(estimate: Estimate, *parts: Found) -> Found:
    status = max((part.status for part in parts), key=_ORDER.index)
    return Found(estimate, status, float(np.hypot.reduce([part.blind_mm for part in parts])))


def _highest(nodes: FloatArray, back_mm: float) -> FloatArray:
    d = nodes[:, 0] - back_mm
    candidates = nodes[(d >= _TIP_D_MM[0]) & (d <= _TIP_D_MM[1])]
    pool = candidates if len(candidates) else nodes
    return np.asarray(pool[np.argmax(pool[:, 1])])


def _height_at(curve: Curve, nodes: FloatArray, place: Estimate) -> Found | None:
    tip = int(np.argmax(nodes[:, 1]))
    field = nodes[tip:]
    if not len(field):
        return None
    start = field[np.argmin(np.abs(field[:, 0] - place.value))]
    return curve.read(1, place, start, _TREAD_WINDOW)


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
    tread = _tread(nodes, back, _TREAD_D_MM)
    if tread is None:
        return None, None
    d, r = tread
    at_d = float(d[np.argmax(reference.height_mm(d - TAPE_D_MM) - r)])
    height = _height_at(curve, nodes, back.estimate + at_d)
    if height is None:
        return None, None
    nominal = reference.nominal[Quantity.FLANGE_HEIGHT]
    drop = tip.estimate - height.estimate
    wear = drop + (float(reference.height_mm(at_d - TAPE_D_MM)) - nominal)
    return _combined(wear, tip, height, back), at_d


def _hollow(curve: Curve, nodes: FloatArray, back: Found) -> Found | None:
    """Read how far the tread lies below the highest place on its field side."""
    tread = _tread(nodes, back, _HOLLOW_D_MM)
    if tread is None:
        return None
    d, r = tread
    high = int(np.argmax(r - np.minimum.accumulate(r)))
    low = int(np.argmin(r[: high + 1]))
    if high == low:  # It falls all the way to the field side, as a new one does.
        return Found(Estimate.exact(0.0, len(curve)), back.status)
    top = _height_at(curve, nodes, back.estimate + float(d[high]))
    bottom = _height_at(curve, nodes, back.estimate + float(d[low]))
    if top is None or bottom is None:
        return None
    depth = top.estimate - bottom.estimate
    if not depth.value > 0.0:
        depth = Estimate(0.0, depth.gradient)
    return _combined(depth, top, bottom, back)


def _tread(
    nodes: FloatArray, back: Found, span_d_mm: tuple[float, float]
) -> tuple[FloatArray, FloatArray] | None:
    """Return d and r of the tread, smoothed, every millimetre of a span; None if too much hides."""
    d_nodes = nodes[:, 0] - back.estimate.value
    on_tread = (d_nodes > TAPE_D_MM - 20.0) & (nodes[:, 1] < nodes[:, 1].max() - 14.0)
    d_seen, r_seen = d_nodes[on_tread], nodes[on_tread, 1]
    d = np.arange(span_d_mm[0], span_d_mm[1] + 0.5)
    near = np.abs(d[:, None] - d_seen)
    share = near <= _TREAD_SMOOTHING_MM
    seen = share.sum(axis=1) >= 3
    if not seen.mean() >= _MIN_TREAD_SHARE:
        return None
    return d[seen], (share[seen] @ r_seen) / share[seen].sum(axis=1)
