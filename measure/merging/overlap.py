"""Where two sensors see the same steel: how far apart they place it, and what could explain it."""

from dataclasses import dataclass, replace

import numpy as np

from calib import BoolArray, FloatArray, IntArray
from measure.gauging.uncertainty import Learnt, Motions
from measure.placing.template import Template

_STRETCH_MM = 1.5
_FEWEST = 3
# At the edge of the rim each sensor sees a corner from its own side.
_END_MM = 4.0
# Lines through a stretch leave what the profile bends otherwise than the reference.
_FLOOR_MM = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class Strand:
    """The points of one sensor over the reference, with all that may move them.

    Attributes
    ----------
    points_mm
        Shape (N, 2), (a, r).
    sigma_mm
        Shape (N,), across the profile as it counts in a mean.
    motions
        What may move them.
    """

    points_mm: FloatArray
    sigma_mm: FloatArray
    motions: Motions

    def without(self, learnt: Learnt) -> "Strand":
        """Return the strand with what was learnt taken out of its points."""
        displaced = self.motions.displaced_mm(learnt.causes)
        return replace(self, points_mm=self.points_mm - displaced)

    def settled(self) -> "Strand":
        """Return the strand with no motion left: to be compared where nothing is to be learnt."""
        none = np.zeros((len(self.points_mm), 2, 0))
        return replace(self, motions=replace(self.motions, once_mm=none, shared_mm=none))


@dataclass(frozen=True, slots=True, eq=False)
class Overlap:
    """How far two strands lie apart where both are, along the reference's normal.

    Attributes
    ----------
    apart_mm
        Shape (B,): the one minus the other.
    sigma_mm
        Shape (B,): from the points' own scatter.
    by_cause
        Shape (B, U): for one sigma of each cause, those of a shot first, then the shared ones.
    outward
        Shape (B, 2): the reference's normal.
    number
        Shape (B,): which stretch of the reference each is.
    of_one, of_other
        Shape (N,), (M,): the stretch that each point of the strands is in; -1 of those beside.
    """

    apart_mm: FloatArray
    sigma_mm: FloatArray
    by_cause: FloatArray
    outward: FloatArray
    number: IntArray
    of_one: IntArray
    of_other: IntArray

    def __len__(self) -> int:
        return len(self.apart_mm)

    @classmethod
    def of(cls, one: Strand, other: Strand, shift_mm: FloatArray, template: Template) -> "Overlap":
        """Compare two strands on the flange tip, its back and the tread, clear of worn edges.

        Parameters
        ----------
        one, other
            The strands.
        shift_mm
            (y, z) of the reference = (a, r) - shift.
        template
            The reference.
        """
        ours, theirs = (_Stretches.of(each, shift_mm, template) for each in (one, other))
        number, at, there = np.intersect1d(
            ours.number, theirs.number, assume_unique=True, return_indices=True
        )
        return cls(
            apart_mm=ours.outside_mm[at] - theirs.outside_mm[there],
            sigma_mm=np.sqrt(ours.variance_mm2[at] + theirs.variance_mm2[there] + _FLOOR_MM**2),
            by_cause=ours.by_cause[at] - theirs.by_cause[there],
            outward=ours.outward[at],
            number=number,
            of_one=ours.of_point,
            of_other=theirs.of_point,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """A strand in stretches of the reference, by number along it: height outside at their middles.

    A straight line is laid through the points of each; its height is a weighted sum of them.
    """

    number: IntArray
    outside_mm: FloatArray
    variance_mm2: FloatArray
    by_cause: FloatArray
    outward: FloatArray
    of_point: IntArray

    @classmethod
    def of(cls, strand: Strand, shift_mm: FloatArray, template: Template) -> "_Stretches":
        along, outside, nearest = template.place(strand.points_mm - shift_mm)
        inside = along < template.along_mm[-1] - _END_MM
        fit = np.flatnonzero(template.wears_smoothly(along) & inside)
        place = np.floor(along[fit] / _STRETCH_MM).astype(np.int64)
        order = np.argsort(place, kind="stable")
        fit, place = fit[order], place[order]
        number, start, member = np.unique(place, return_index=True, return_inverse=True)
        middle = (number + 0.5) * _STRETCH_MM
        weight, good = _line_weights(along[fit] - middle[member], strand.sigma_mm[fit], member)
        normal = template.outward[nearest[fit]]
        sums = _WeightedSums(weight, start, good)
        causes = [strand.motions.once_mm[fit], strand.motions.shared_mm[fit]]
        motion = np.concatenate([_along(normal, each) for each in causes], axis=1)
        of_point = np.full(len(along), -1, dtype=np.int64)
        of_point[fit] = place
        return cls(
            number=number[good],
            outside_mm=sums.of(outside[fit]),
            variance_mm2=sums.of(weight * strand.sigma_mm[fit] ** 2),
            by_cause=sums.of(motion),
            outward=sums.of(normal),
            of_point=of_point,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _WeightedSums:
    """Sums over the points of each stretch, which come stretch after stretch."""

    weight: FloatArray
    start: IntArray
    good: BoolArray

    def of(self, values: FloatArray) -> FloatArray:
        """Return the weighted sums of values of the points, shape (N,) or (N, K)."""
        if not len(self.start):
            return np.zeros((0, *values.shape[1:]))
        weighted = (values.T * self.weight).T
        return np.asarray(np.add.reduceat(weighted, self.start)[self.good])


def _along(normal: FloatArray, motion_mm: FloatArray) -> FloatArray:
    """Return motions, shape (N, 2, K), along normals, shape (N, 2), as shape (N, K)."""
    return np.asarray(normal[:, :1] * motion_mm[:, 0] + normal[:, 1:] * motion_mm[:, 1])


def _line_weights(
    s: FloatArray, sigma_mm: FloatArray, member: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Return the weight of each point in the height, at s = 0, of the line through its stretch.

    And which stretches have points enough, on both sides of their middle.
    """
    certainty = 1.0 / sigma_mm**2
    count, before = np.bincount(member), np.bincount(member, s < 0.0)
    good = (count >= _FEWEST) & (before > 0) & (before < count)
    sums = [np.bincount(member, certainty * s**power) for power in range(3)]
    determinant = sums[0] * sums[2] - sums[1] ** 2
    safe = np.where(good & (determinant > 0.0), determinant, np.inf)
    weight = certainty * (sums[2][member] - sums[1][member] * s) / safe[member]
    return weight, good & (determinant > 0.0)
