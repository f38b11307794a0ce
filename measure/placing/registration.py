"""Laying a section over the reference by what does not wear: flange back and tip."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray, IntArray, StripePoints
from measure.placing.belonging import can_be_wheel, mostly_wheel
from measure.placing.pieces import pieces
from measure.placing.template import Template

_ROUNDS = 6
NEAR_MM = 3.0
"""Points farther from the reference are another thing than the unworn side of its flange."""
_CLOSE_MM = 1.2
_ON_MM = 0.1
_CLEAR_SHARE = 0.8
_BESIDE_MM = ((0.0, 0.0), (0.0, -2.5), (0.0, 2.5), (-2.0, 0.0), (2.0, 0.0))
_EVERY = 3  # points, while places are tried
_HUBER_MM = 0.1
# Holds the place where too little is seen to move it, and yields to any real evidence.
_PRIOR_MM = 3.0
_BACK_NEAR_MM = 5.0
_MIN_BACK_POINTS = 10
_MIN_BACK_SPAN_MM = 2.0


def refine_shift(
    points_mm: FloatArray,
    shift_mm: FloatArray,
    template: Template,
    *,
    near_mm: float = NEAR_MM,
) -> FloatArray:
    """Improve the shift from (a, r) to the reference's (y, z) on the unworn side of the flange.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (a, r).
    shift_mm
        Shape (2,), within 2 mm or so: (y, z) = (a, r) - shift.
    template
        The reference.
    near_mm
        Points farther from the reference have no part in it.

    Returns
    -------
    shift_mm
        Shape (2,).
    """
    start = shift_mm
    tip_y = template.points_mm[template.tip, 0]
    points_mm = points_mm[points_mm[:, 0] - shift_mm[0] < tip_y + 2.0 * NEAR_MM]
    for _ in range(_ROUNDS):
        along, outside, nearest = template.place(points_mm - shift_mm)
        use = template.is_unworn(along) & (np.abs(outside) < near_mm)
        normal, error = template.outward[nearest[use]], outside[use]
        scale = max(_HUBER_MM, 1.5 * float(np.median(np.abs(error))) if len(error) else 0.0)
        weight = np.minimum(1.0, scale / np.maximum(np.abs(error), 1e-12)) / scale**2
        prior = np.eye(2) / _PRIOR_MM**2
        hessian = (normal * weight[:, None]).T @ normal + prior
        step = np.linalg.solve(
            hessian, (normal * weight[:, None]).T @ error - prior @ (shift_mm - start)
        )
        shift_mm = shift_mm + step
        if np.abs(step).max() < 1e-4:
            break
    return shift_mm


def best_shift(
    points_mm: FloatArray,
    stripe: StripePoints,
    shifts_mm: Sequence[FloatArray],
    template: Template,
) -> FloatArray:
    """Return the shift that lays one whole profile on the reference, unworn side on unworn side.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (a, r).
    stripe
        The same points in the picture.
    shifts_mm
        Where flanges seem to be. Around each, places beside it are tried too: a stripe and its
        reflection may overlap, and the vote then falls between them.
    template
        The reference.

    Returns
    -------
    shift_mm
        Shape (2,), refined.

    Notes
    -----
    A stripe of another light than the laser's, laid out by the laser's sheet, is out of shape: its
    flange fits the reference less well, and where its flange fits its tread does not. And it is
    wider: reflection and penumbra spread light, nothing makes it narrower than the laser's sheet.
    What counts is therefore the fit of the unworn side times the share of the profile that is
    there, over the square of the stripe's width.
    """
    if len(shifts_mm) == 1:
        plain = refine_shift(points_mm, shifts_mm[0], template)
        if _clear(points_mm - plain, template):
            return plain
    piece = pieces(stripe.centre_px, stripe.normal)
    best_mm, best_points, best_merit = shifts_mm[0], points_mm, -1.0
    for shift in shifts_mm:
        mine = _own(points_mm - shift, piece, template)
        if not mine.any():
            continue
        own, width_px = points_mm[mine], float(np.median(stripe.width_px[mine]))
        few = own[::_EVERY]
        for refined in _tried(few, shift, template):
            merit = _merit(few - refined, template) / width_px**2
            if merit > best_merit:
                best_mm, best_points, best_merit = refined, own, merit
    return refine_shift(best_points, best_mm, template, near_mm=_CLOSE_MM)


def _tried(points_mm: FloatArray, shift_mm: FloatArray, template: Template) -> list[FloatArray]:
    """Return refined shifts, from one and, where that leaves doubt, from places beside it."""
    refined = refine_shift(points_mm, shift_mm, template)
    if _clear(points_mm - refined, template):
        return [refined]
    beside = [
        refine_shift(points_mm, refined + step, template, near_mm=_CLOSE_MM) for step in _BESIDE_MM
    ]
    return [refined, *beside]


def _own(points_mm: FloatArray, piece: IntArray, template: Template) -> BoolArray:
    """Tell which points hang together with a wheel that lies so."""
    along, outside, nearest = template.place(points_mm)
    inside = can_be_wheel(along, outside, nearest, template)
    return inside & mostly_wheel(inside, along, piece, template)


def _clear(points_mm: FloatArray, template: Template) -> bool:
    """Whether nearly all that is near the unworn side of the reference lies on it."""
    along, outside, _ = template.place(points_mm)
    near = np.abs(outside[template.is_unworn(along) & (np.abs(outside) < NEAR_MM)])
    return len(near) > 0 and float(np.mean(near < _ON_MM)) > _CLEAR_SHARE


def _merit(points_mm: FloatArray, template: Template) -> float:
    """Count the points on the unworn side, the nearer the more, times the share of profile seen."""
    along, outside, nearest = template.place(points_mm)
    fit = np.sum(np.exp(-0.5 * (outside[template.is_unworn(along)] / _ON_MM) ** 2))
    running = np.unique(nearest[nearest > template.tip])
    return float(fit) * len(running) / (len(template) - template.tip)


def tip_misfit_mm(points_mm: FloatArray, template: Template) -> float:
    """Return how far laid points, (y, z), lie off the unworn arc of the tip, by their median.

    Zero where none is seen there: that the tip hides is told by whoever reads it.
    """
    along, outside, nearest = template.place(points_mm)
    arc = np.abs(outside[template.is_unworn(along) & (nearest >= template.back_count)])
    return float(np.median(arc)) if len(arc) else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class BackFace:
    """The flange back as seen: its lateral place a as a weighted mean of points."""

    a_mm: float
    gradient: FloatArray


def see_back_face(
    points_mm: FloatArray, sigma_mm: FloatArray, shift_mm: FloatArray, template: Template
) -> BackFace | None:
    """Find the lateral place of the back face, or None where too little of it is seen.

    Only its place is taken; its direction comes from the calibration, as a few millimetres of
    it would leave a rotation of tenths of a degree.
    """
    y, z = (points_mm - shift_mm).T
    y_back = template.points_mm[0, 0]
    on_face = np.flatnonzero((z < template.back_top_mm) & (np.abs(y - y_back) < _BACK_NEAR_MM))
    for _ in range(3):
        if len(on_face) < _MIN_BACK_POINTS or np.ptp(z[on_face]) < _MIN_BACK_SPAN_MM:
            return None
        a = points_mm[on_face, 0]
        off = np.abs(a - np.median(a))
        limit = 4.0 * max(1.4826 * float(np.median(off)), 0.02)
        if (off <= limit).all():
            break
        on_face = on_face[off <= limit]
    weight = 1.0 / sigma_mm[on_face] ** 2
    weight /= weight.sum()
    gradient = np.zeros_like(points_mm)
    gradient[on_face, 0] = weight
    return BackFace(float(weight @ points_mm[on_face, 0]), gradient)
