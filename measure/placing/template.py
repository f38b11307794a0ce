"""The reference as points to compare with: where on the wheel a point belongs."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from calib import BoolArray, FloatArray, IntArray
from measure.reference import BACK_Y_MM, ReferenceProfile

_STEP_MM = 0.5
_BACK_FACE_MM = 40.0
_BACK_FACE_CLEARANCE_MM = 1.0
_PAST_TIP_MM = 2.0
_THROAT_END_Y_MM = -15.0


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """Evenly spaced points of a reference, back face and all.

    Attributes
    ----------
    points_mm
        Shape (M, 2), (y, z) from the foot of the back face to the field side.
    tangent, outward
        Shape (M, 2), unit, along the profile and out of the wheel.
    along_mm
        Shape (M,), place along the profile.
    tip
        Which of them is the flange tip.
    back_top_mm
        Height z below which the back face is straight.
    back_count
        How many of the points lie on the straight back face.
    """

    points_mm: FloatArray
    tangent: FloatArray
    outward: FloatArray
    along_mm: FloatArray
    tip: int
    back_top_mm: float
    back_count: int
    tree: cKDTree

    @classmethod
    def of(cls, reference: ReferenceProfile) -> "Template":
        """Make the template of a reference."""
        points = reference.points(_STEP_MM, back_face_mm=_BACK_FACE_MM)
        tangent = np.gradient(points, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        outward = tangent[:, ::-1] * [-1.0, 1.0]
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        straight = points[:, 0] <= BACK_Y_MM + 1e-3
        top = float(points[straight, 1].max()) - _BACK_FACE_CLEARANCE_MM
        tip = int(np.argmax(points[:, 1]))
        below = int(np.argmax(points[:, 1] > top))
        return cls(points, tangent, outward, along, tip, top, below, cKDTree(points))

    def __len__(self) -> int:
        return len(self.points_mm)

    def place(self, points_mm: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return place along, height outside, and nearest template point, of points (y, z)."""
        nearest = np.asarray(self.tree.query(points_mm)[1], dtype=np.int64)
        offset = points_mm - self.points_mm[nearest]
        along = self.along_mm[nearest] + np.sum(offset * self.tangent[nearest], axis=1)
        outside = np.sum(offset * self.outward[nearest], axis=1)
        return along, outside, nearest

    def is_unworn(self, along_mm: FloatArray) -> BoolArray:
        """Tell which places are on the back and the tip of the flange, which do not wear."""
        return np.asarray(along_mm < self.along_mm[self.tip] + _PAST_TIP_MM)

    def is_tread(self, nearest: IntArray) -> BoolArray:
        """Tell which points of the template lie on the running tread, clear of the throat."""
        return np.asarray(self.points_mm[nearest, 0] > _THROAT_END_Y_MM)

    def wears_smoothly(self, along_mm: FloatArray) -> BoolArray:
        """Tell which places are clear of the flange face and the throat, where edges wear in."""
        start = self.along_mm[self.tip] + _PAST_TIP_MM
        end = self.along_mm[np.argmax(self.points_mm[:, 0] > _THROAT_END_Y_MM)]
        return np.asarray((along_mm < start) | (along_mm > end))

    def flange(self) -> IntArray:
        """Return the points of the flange: a piece of back face, the tip, the face."""
        y, z = self.points_mm.T
        return np.flatnonzero((y < -35.0) & (z > self.back_top_mm - 12.0))


@lru_cache(maxsize=16)
def template_of(reference: ReferenceProfile) -> Template:
    """Return the template of a reference, made once."""
    return Template.of(reference)
