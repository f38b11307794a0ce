"""Laying a section over the reference by what does not wear: flange back and tip."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.template import Template

_ROUNDS = 6
_NEAR_MM = 3.0
_HUBER_MM = 0.1
# Behind the tip and down the back; the face in front of it wears.
_PAST_TIP_MM = 2.0
# Holds the place where too little is seen to move it, and yields to any real evidence.
_PRIOR_MM = 3.0
_BACK_NEAR_MM = 5.0
_MIN_BACK_POINTS = 10
_MIN_BACK_SPAN_MM = 2.0


def refine_shift(points_mm: FloatArray, shift_mm: FloatArray, template: Template) -> FloatArray:
    """Improve the shift from (a, r) to the reference's (y, z) on the unworn side of the flange.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (a, r).
    shift_mm
        Shape (2,), within 2 mm or so: (y, z) = (a, r) - shift.

    Returns
    -------
    shift_mm
        Shape (2,).
    """
    start = shift_mm
    tip_y = template.points_mm[template.tip, 0]
    points_mm = points_mm[points_mm[:, 0] - shift_mm[0] < tip_y + 2.0 * _NEAR_MM]
    for _ in range(_ROUNDS):
        along, outside, nearest = template.place(points_mm - shift_mm)
        unworn = along < template.along_mm[template.tip] + _PAST_TIP_MM
        use = unworn & (np.abs(outside) < _NEAR_MM)
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


def unworn_misfit_mm(points_mm: FloatArray, shift_mm: FloatArray, template: Template) -> float:
    """Return the median distance from the reference of the points on its unworn side."""
    along, outside, _ = template.place(points_mm - shift_mm)
    unworn = along < template.along_mm[template.tip] + _PAST_TIP_MM
    near = np.abs(outside[unworn & (np.abs(outside) < _NEAR_MM)])
    return float(np.median(near)) if len(near) else float("inf")


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
