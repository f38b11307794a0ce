"""The dots of a target in one picture: found, numbered, measured."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, IntArray, Picture
from calib.seeing.dots_centre import DotCentres, measure_dots
from calib.seeing.dots_find import find_dots
from calib.seeing.dots_soft import SOFT_FROM_PX, blur_px, light_over_outline, without_dots
from calib.seeing.ellipse import Ellipses
from calib.seeing.lattice import Lattice, find_lattice
from calib.seeing.noise import PixelNoise
from calib.seeing.placed import Placed
from calib.seeing.seen import SeenTarget
from calib.seeing.stripe_lines import StripeLine
from calib.seeing.stripe_on_board import BoardArea, BoardStripes
from calib.target import Target
from calib.views import Cause

_LARGEST_SIGMA = 0.06  # of the radius
_CROSSED_FROM = 0.02
_CLIPPED_FROM = 0.03
_FAINTEST = 0.25  # of the median height
_SIZE_RATIO = 1.3
_WIDTHS_IN_GAP = 6.0
_GLARE_SLOPE = 0.3
_GLARE_GROUND = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class DotPattern:
    """Dots on a common lattice, not yet numbered.

    Attributes
    ----------
    lattice
        The lattice.
    outlines
        Rough outlines, in the order of the lattice's points.
    """

    lattice: Lattice
    outlines: Ellipses

    def __len__(self) -> int:
        return len(self.lattice)

    @classmethod
    def find(cls, picture: Picture, noise: PixelNoise, target: Target) -> "DotPattern | None":
        """Find the dots of a target; None where none make a lattice."""
        dots = find_dots(picture, noise, dark=target.dark)
        lattice = find_lattice(dots.centre_px, dots.radius_px, target.rows, target.cols)
        return None if lattice is None else cls(lattice, dots.picked(lattice.index))

    def without_marks(self, picture: Picture) -> Picture:
        """Return the picture as it is: sharp dots leave enough of a narrow stripe clear."""
        return picture

    def cleared(
        self, picture: Picture, noise: PixelNoise, target: Target, stripes: BoardStripes
    ) -> Picture | None:
        """Return the picture without the dots; None where they are out of the stripe's way.

        They are in its way where a stripe is as wide as the gaps, so that no line is found or
        one that is never clear of them, and where dots are so soft that their light is all over
        the board.
        """
        gap_px = self.area(target).pitch_px - 2.0 * float(np.median(self.outlines.radius_px))
        lines = stripes.lines
        narrow = bool(lines) and lines[0].width_px * _WIDTHS_IN_GAP <= gap_px
        if narrow and blur_px(picture, self.outlines) < SOFT_FROM_PX:
            return None
        # What a wide stripe adds is a slope to a dot's edge; masked, no edge would be left.
        dots = measure_dots(
            picture, noise, self.outlines, lines if narrow else [], dark=target.dark
        )
        good = dots.trusted
        return without_dots(picture, dots.parameters[good], dots.origin[good])

    def area(self, target: Target) -> BoardArea:
        """Return where the target may be in the picture."""
        low, high = self.lattice.extent(target.rows, target.cols)
        return BoardArea(self.lattice.picture_from_node, low, high, self.outlines)

    def numbered(
        self, picture: Picture, noise: PixelNoise, target: Target, lines: list[StripeLine]
    ) -> SeenTarget | None:
        """Measure the dots, those that the lattice predicts as well, and number them.

        Parameters
        ----------
        picture, noise, target
            As the dots were found with.
        lines
            Stripes across the dots.

        Returns
        -------
        SeenTarget or None
            None where the numbering is not certain.
        """
        mine, empty = self.lattice.within_target(target.rows, target.cols)
        node = np.concatenate([self.lattice.node[mine], empty])
        outlines = self.outlines.picked(mine).joined(_expected_outlines(self, empty))
        dots = measure_dots(picture, noise, outlines, lines, dark=target.dark)
        placed = Placed.of(
            self.lattice,
            node,
            target,
            countable=_like_the_others(dots, int(mine.sum())),
            # Good enough to count by, a dot may still be too poor to measure with.
            measurable=dots.sigma_px.max(axis=1) < _LARGEST_SIGMA * dots.outlines.radius_px,
            centre_px=dots.centre_px,
            sigma_px=dots.sigma_px,
        )
        if placed is None:
            return None
        return SeenTarget(
            placed.place,
            dots.centre_px[placed.index],
            dots.sigma_px[placed.index],
            _causes(dots, placed.index),
            placed.picture_from_board,
            dots.outlines.picked(placed.index),
            light_over_outline(dots.parameters[placed.index]),
        )


def _expected_outlines(pattern: DotPattern, node: IntArray) -> Ellipses:
    """Return outlines at empty nodes: as large as the three nearest dots that are seen."""
    lattice, outlines = pattern.lattice, pattern.outlines
    centre = lattice.predict(node) if len(node) else np.empty((0, 2))
    gap = np.linalg.norm(centre[:, None] - outlines.centre_px[None], axis=2)
    nearest = np.argsort(gap, axis=1)[:, :3]
    # What is off the lattice here, by distortion, is off beside as well.
    off = outlines.centre_px - lattice.predict(lattice.node)
    return Ellipses(
        centre + np.median(off[nearest], axis=1), np.median(outlines.form[nearest], axis=1)
    )


def _like_the_others(dots: DotCentres, found: int) -> BoolArray:
    """Return which dots are of the size and not much fainter than those first `found`."""
    first = np.flatnonzero(dots.trusted[:found])
    if first.size == 0:
        return np.zeros(len(dots), dtype=bool)
    gap = np.linalg.norm(dots.centre_px[:, None] - dots.centre_px[None, first], axis=2)
    near = first[np.argsort(gap, axis=1)[:, : min(6, first.size)]]
    size = dots.outlines.radius_px / np.median(dots.outlines.radius_px[near], axis=1)
    height = dots.height / np.median(dots.height[near], axis=1)
    # A light may fall off across the board; a chance find beside it is fainter still.
    alike = (np.abs(np.log(size)) < np.log(_SIZE_RATIO)) & (height > _FAINTEST)
    return np.asarray(dots.trusted & alike)


def _causes(dots: DotCentres, index: IntArray) -> tuple[Cause, ...]:
    """Say what is doubtful about each dot."""
    ground = np.median(dots.ground[index])
    height = np.median(dots.height[index])
    causes = []
    for i in index:
        if dots.hidden[i] > _CROSSED_FROM:
            causes.append(Cause.CROSSED)
        elif dots.clipped[i] > _CLIPPED_FROM:
            causes.append(Cause.SATURATED)
        elif (
            dots.slope[i] > _GLARE_SLOPE * dots.height[i]
            or dots.ground[i] - ground > _GLARE_GROUND * height
        ):
            causes.append(Cause.GLARE)
        else:
            causes.append(Cause.NONE)
    return tuple(causes)
