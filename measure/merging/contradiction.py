"""Pieces of stripe that another sensor contradicts: light that is not the laser's, on one wheel."""

from collections.abc import Sequence

import numpy as np

from calib import BoolArray, IntArray
from measure.laying.by_axle import MIN_WHEEL_POINTS, Laid
from measure.merging.overlap import Overlap
from measure.placing.pieces import pieces, sizes

# Put together, two sensors' stretches agree within their scatter, and what bends leave.
_ODD_SIGMAS, _ODD_MM = 5.0, 0.08
# A piece of which so much is contradicted is false as a whole: the rest crosses the wheel's line.
_FALSE_SHARE = 0.25


def without_contradictions(
    parts: Sequence[Laid], overlaps: Sequence[Overlap]
) -> tuple[Laid, ...] | None:
    """Return the parts without what the first or the others contradict; None where nothing is.

    Parameters
    ----------
    parts
        Of several sensors.
    overlaps
        Of the first with each other one, their points put together as well as they can be.
    """
    kept = [np.ones(len(part.along_mm), dtype=bool) for part in parts]
    for place, overlap in enumerate(overlaps, start=1):
        of_first, of_other = _contradicted(parts[0], parts[place], overlap)
        kept[0] &= ~of_first
        kept[place] &= ~of_other
    # A part that would lose nearly all is no part: it stays, and is judged as a whole.
    lost = [not keep.all() and keep.sum() >= MIN_WHEEL_POINTS for keep in kept]
    if not any(lost):
        return None
    return tuple(
        part.select(np.flatnonzero(keep)) if drop else part
        for part, keep, drop in zip(parts, kept, lost, strict=True)
    )


def _contradicted(one: Laid, other: Laid, overlap: Overlap) -> tuple[BoolArray, BoolArray]:
    """Tell which points of two parts the other one contradicts, shapes (N,) and (M,).

    Parameters
    ----------
    one, other
        The parts.
    overlap
        Of their points, put together as well as they can be.

    Notes
    -----
    A reflection that lies over the wheel for a while hides the true stripe there, and passes for
    it; a second sensor sees that part of the wheel without it, or with another. Of two pieces of
    stripe that contradict each other the longer one is believed: the wheel's hangs together over
    most of the profile. The shorter one is left out, and where a good part of it is contradicted
    all of it, for a false stripe crosses the wheel's line somewhere.
    """
    odd = np.abs(overlap.apart_mm) > np.maximum(_ODD_SIGMAS * overlap.sigma_mm, _ODD_MM)
    if not odd.any():
        return np.zeros(len(one.along_mm), dtype=bool), np.zeros(len(other.along_mm), dtype=bool)
    strands = [_Pieces(one, overlap.of_one, overlap), _Pieces(other, overlap.of_other, overlap)]
    lengths = [strand.longest(overlap.number) for strand in strands]
    shorter = lengths[0] < lengths[1]
    return strands[0].false(odd & shorter), strands[1].false(odd & ~shorter)


class _Pieces:
    """The points of a part by stretch of the overlap and by piece of stripe."""

    def __init__(self, part: Laid, stretch: IntArray, overlap: Overlap) -> None:
        self._numbers = overlap.number
        self._stretch = stretch
        self._piece = pieces(part.sheet.stripe.centre_px, part.sheet.stripe.normal)
        self._size = sizes(self._piece)

    def longest(self, numbers: IntArray) -> IntArray:
        """Return the length, in points, of the longest piece in each stretch."""
        return np.array([self._size[self._stretch == number].max() for number in numbers])

    def false(self, lost: BoolArray) -> BoolArray:
        """Tell which points are false where this part has lost some of the stretches."""
        in_lost = np.isin(self._stretch, self._numbers[lost])
        compared = np.isin(self._stretch, self._numbers)
        share = np.bincount(self._piece, in_lost) / np.maximum(
            np.bincount(self._piece, compared), 1.0
        )
        return np.asarray(in_lost | (share >= _FALSE_SHARE)[self._piece])
