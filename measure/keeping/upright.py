"""Whether what stands where the flange back should be is the flange back."""

import numpy as np

from calib import BoolArray, FloatArray, IntArray
from measure.placing.registration import refine_shift
from measure.placing.template import Template

# The stripe shows every 0.3 to 0.4 mm; two steps at once are a gap, or a jump to another thing.
_JOINED_MM = 0.8
_JOINT_MM = 4.0
# By itself it is believed where the arc of the tip says: flanges keep their form to a quarter of
# a millimetre.
_ASIDE_MM = 0.25
# Where the stripe goes on without a break, a flange of another form than the reference may be it:
# the arcs of S1002 and LMA put the back 1 mm apart. Not where other light could have joined it.
_ASIDE_IF_JOINED_MM, _ASIDE_IF_ALONE_MM = 0.6, 1.5
# A back face is turned flat. Survey and oblique cuts leave 2 mrad, noise over the shortest piece
# that is judged as much again.
_TILT = 0.01
_JUDGED_SPAN_MM = 8.0
_FEWEST = 12


def false_back(
    points_mm: FloatArray, nearest: IntArray, template: Template, *, alone: bool
) -> BoolArray:
    """Tell which points of a laid profile only seem to be the flange back.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (y, z), in order from the flange back to the field side.
    nearest
        Shape (N,), the point of the template nearest to each.
    template
        The reference.
    alone
        Whether the picture shows hardly a line besides this profile.

    Returns
    -------
    leave_out
        Shape (N,): points of the straight face, or none.

    Notes
    -----
    The flange back is the lateral datum of all readings, and often the dimmest part of the
    stripe: where it is too dark, a reflection or a lit thing beside it can take its place. A face
    that goes on into the arc of the tip is its back, if it stands about where the arc says;
    otherwise only what stands exactly there is. Neither may lean.
    """
    on_face = np.flatnonzero(nearest < template.back_count)
    leave_out = np.zeros(len(points_mm), dtype=bool)
    face, rest = points_mm[on_face], points_mm[nearest >= template.back_count]
    if len(face) < _FEWEST or len(rest) < _FEWEST:
        return leave_out
    aside = np.abs(face[:, 0] - _place_by_tip_mm(rest, template))
    most_mm = _ASIDE_IF_ALONE_MM if alone else _ASIDE_IF_JOINED_MM
    joined = _joined(points_mm, template) and np.median(aside) <= most_mm
    if joined and not _leans(face):
        return leave_out
    in_place = aside <= _ASIDE_MM
    good = in_place.sum() >= _FEWEST and not _leans(face[in_place])
    leave_out[on_face[~in_place] if good else on_face] = True
    return leave_out


def _leans(face_mm: FloatArray) -> bool:
    """Whether the two halves of the face lie aside of one another by more than a face can lean."""
    y, z = face_mm.T
    if np.ptp(z) < _JUDGED_SPAN_MM:
        return False
    upper = z > np.median(z)
    aside = float(np.median(y[upper]) - np.median(y[~upper]))
    apart = float(np.median(z[upper]) - np.median(z[~upper]))
    return abs(aside) > _TILT * apart


def _joined(points_mm: FloatArray, template: Template) -> bool:
    """Whether the stripe goes on without a gap or a step from the face to the tip."""
    y, z = points_mm.T
    tip_y, top = template.points_mm[template.tip, 0], template.back_top_mm
    way = points_mm[(y < tip_y) & (z > top - _JOINT_MM)]
    if not (len(way) and way[-1, 0] > tip_y - _JOINED_MM):
        return False
    return bool(np.linalg.norm(np.diff(way, axis=0), axis=1).max(initial=0.0) <= _JOINED_MM)


def _place_by_tip_mm(rest_mm: FloatArray, template: Template) -> float:
    """Return the lateral place of the back as the arc of the tip tells it."""
    moved = refine_shift(rest_mm, np.zeros(2), template)
    return float(template.points_mm[0, 0] + moved[0])
