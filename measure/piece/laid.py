"""Points that lie on a piece, whoever saw them: what its dimensions are told from."""

from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray, IntArray
from measure.piece.certified import Piece


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LaidPoints:
    """The points that lie on a piece, in order along its profile.

    Attributes
    ----------
    piece
        What they lie on.
    face
        Shape (N,), index of the side of each point.
    along_mm
        Shape (N,), place along its side.
    outside_mm
        Shape (N,), how far out of the certified profile it lies.
    points_mm, normal
        Shape (N, 2), in the piece's frame: the point, and the direction out of the metal.
    length_mm
        Shape (N,), its place along the piece's length, from their middle; 0 where all points are
        taken to lie in one section.
    sigma_mm
        Shape (N,): standard deviation along the normal as it counts in a mean: speckle in it,
        and what neighbours share.
    by_sensor_mm
        Shape (N, P): motion along the normal by the parameters of the sensor, or of the rig.
    bend_mm
        Shape (N,): what was taken off for the bend of the stripe; on round sides only.
    slant_rad, slant_sigma_rad
        How far the piece's length, as it was laid, is turned about its x and its z from where its
        holder should keep it, shape (2,), and how well the holder does.
    """

    piece: Piece
    face: IntArray
    along_mm: FloatArray
    outside_mm: FloatArray
    points_mm: FloatArray
    normal: FloatArray
    length_mm: FloatArray
    sigma_mm: FloatArray
    by_sensor_mm: FloatArray
    bend_mm: FloatArray
    slant_rad: FloatArray
    slant_sigma_rad: float

    def __len__(self) -> int:
        return len(self.face)

    @property
    def rms_mm(self) -> float:
        """Root mean square of the distances from the profile."""
        return float(np.sqrt(np.mean(self.outside_mm**2)))

    @property
    def turning_mm(self) -> FloatArray:
        """What a small turn about the middle of the points moves each along its normal, (N,)."""
        arm = self.points_mm - self.points_mm.mean(axis=0)
        return np.asarray(self.normal[:, 1] * arm[:, 0] - self.normal[:, 0] * arm[:, 1])

    @property
    def slanting_mm(self) -> FloatArray:
        """What small turns about the piece's x and z move each along its normal, shape (N, 2)."""
        return np.asarray(self.normal[:, ::-1] * [1.0, -1.0] * self.length_mm[:, None])

    @property
    def seen_mm(self) -> FloatArray:
        """Length of each side between its outermost points, shape (number of sides,)."""
        spans = [self.along_mm[self.face == k] for k in range(len(self.piece.faces))]
        return np.array([float(np.ptp(span)) if len(span) else 0.0 for span in spans])


def usual(face: IntArray, outside_mm: FloatArray, farthest_sigmas: float = 5.0) -> BoolArray:
    """Tell the points that lie with the others of their side, shape (N,)."""
    lies_with = np.ones(len(face), dtype=bool)
    for index in np.unique(face):
        on = np.flatnonzero(face == index)
        off = outside_mm[on] - np.median(outside_mm[on])
        lies_with[on] = np.abs(off) <= farthest_sigmas * max(
            1.4826 * float(np.median(np.abs(off))), 1e-4
        )
    return lies_with
