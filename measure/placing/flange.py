"""Where in a section is a flange, if anywhere?  A vote of all points, blind to strays."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter

from calib import BoolArray, FloatArray, IntArray
from measure.placing.template import Template

_CELL_MM = 2.0
_VOTERS = 350
_EVERY = 3
_SUPPORT_MM = 2.5
_SIN_TANGENT = 0.42  # 25 degrees: a worn face is steeper by as much
_MIN_SHARE = 0.3
_MIN_TIP_SHARE = 0.5
# What a rival needs of the best one's support: another wheel, and the same place by another light.
_RIVAL_SHARE, _SHADOW_SHARE = 0.8, 0.5
WHEELS_APART_MM, NARROWEST_RIM_MM = 30.0, 100.0
"""Flanges farther aside than the first are not of one wheel; those of two are a rim apart."""
# Nearer than this, across and up, it is the same flange again.
_RIVAL_DISTANCE_MM = (30.0, 8.0)
_MOST_SIGHTINGS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Voters:
    """Points of a section with the direction of the stripe and of the camera at each.

    Attributes
    ----------
    points_mm, tangent, to_camera
        Shape (N, 2); the latter two unit and of any length.
    """

    points_mm: FloatArray
    tangent: FloatArray
    to_camera: FloatArray

    def thinned(self) -> "Voters":
        """Return an even choice of a few hundred."""
        step = -(-len(self.points_mm) // _VOTERS)
        return Voters(self.points_mm[::step], self.tangent[::step], self.to_camera[::step])


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A flange that may be: what to take from (a, r) to get (y, z), and how much supports it."""

    shift_mm: FloatArray
    share: float
    tip_share: float

    @property
    def credible(self) -> bool:
        """Whether enough of a flange, and of its tip, is seen."""
        return self.share >= _MIN_SHARE and self.tip_share >= _MIN_TIP_SHARE


def find_flanges(voters: Voters, template: Template) -> tuple[Sighting, ...]:
    """Return the flanges of a section, the best supported first; no flange, no sighting.

    Each point votes for the shifts that put it on a point of the template's flange with the same
    direction, on a side that the camera can see. A shift with many votes is a flange; strays
    vote everywhere. Tread wear moves no flange, and so not the vote. Another sighting is a
    second wheel, if it lies aside and has nearly as much support, or the wheel again by another
    light: of the two the true one may be the dimmer, and half the support suffices.
    """
    few = voters.thinned()
    chosen = template.flange()[::_EVERY]
    difference = few.points_mm[:, None] - template.points_mm[chosen]
    shifts = difference[_agrees(few, template, chosen)]
    found: list[Sighting] = []
    for _ in range(_MOST_SIGHTINGS):
        if not len(shifts):
            break
        sighting = _peak(shifts, few, template)
        if not sighting.credible:
            break
        if not found or _rivals(sighting, found[0]):
            found.append(sighting)
        near = np.abs(shifts - sighting.shift_mm) < _RIVAL_DISTANCE_MM
        shifts = shifts[~near.all(axis=1)]
    return tuple(found)


def _rivals(one: Sighting, best: Sighting) -> bool:
    """Whether a sighting has enough support to be looked at beside the best."""
    aside = abs(one.shift_mm[0] - best.shift_mm[0]) > WHEELS_APART_MM
    return bool(one.share >= (_RIVAL_SHARE if aside else _SHADOW_SHARE) * best.share)


def _agrees(few: Voters, template: Template, chosen: IntArray) -> BoolArray:
    """Which point may lie on which template point, shape (N, M)."""
    tangent, outward = template.tangent[chosen], template.outward[chosen]
    sine = few.tangent[:, :1] * tangent[:, 1] - few.tangent[:, 1:] * tangent[:, 0]
    return np.asarray((np.abs(sine) < _SIN_TANGENT) & (few.to_camera @ outward.T > 0.0))


def _peak(shifts: FloatArray, few: Voters, template: Template) -> Sighting:
    low = shifts.min(axis=0)
    cell = np.floor((shifts - low) / _CELL_MM).astype(np.int64)
    size = cell.max(axis=0) + 1
    votes = np.bincount(cell[:, 0] * size[1] + cell[:, 1], minlength=int(size.prod()))
    smooth = uniform_filter(votes.reshape(size).astype(np.float64), 3, mode="constant")
    best = np.array(np.unravel_index(np.argmax(smooth), smooth.shape))
    inside = (np.abs(cell - best) <= 1).all(axis=1)
    return _support(np.median(shifts[inside], axis=0), few, template)


def _support(shift_mm: FloatArray, few: Voters, template: Template) -> Sighting:
    """Count which flange points of the template have a fitting point near."""
    chosen = template.flange()[::_EVERY]
    gap = few.points_mm[:, None] - shift_mm - template.points_mm[chosen]
    near = np.asarray((np.abs(gap) < _SUPPORT_MM).all(axis=2)) & _agrees(few, template, chosen)
    supported = np.asarray(near.any(axis=0))
    of_tip = np.abs(template.along_mm[chosen] - template.along_mm[template.tip]) < 8.0
    return Sighting(shift_mm, float(supported.mean()), float(supported[of_tip].mean()))
