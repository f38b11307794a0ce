"""The inner corners of a chessboard in one picture: found, numbered, measured."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, Picture
from calib.seeing.corners_centre import measure_corners
from calib.seeing.corners_find import find_corners
from calib.seeing.lattice import Lattice, find_lattice
from calib.seeing.noise import PixelNoise
from calib.seeing.placed import Placed
from calib.seeing.seen import SeenTarget
from calib.seeing.squares import without_black
from calib.seeing.stripe_lines import StripeLine
from calib.seeing.stripe_on_board import BoardArea, BoardStripes
from calib.target import Target


@dataclass(frozen=True, slots=True, eq=False)
class CornerPattern:
    """Corners on a common lattice, not yet numbered.

    Attributes
    ----------
    lattice
        The lattice.
    place_px
        Shape (N, 2), where its points are, to about a pixel.
    """

    lattice: Lattice
    place_px: FloatArray

    def __len__(self) -> int:
        return len(self.lattice)

    @classmethod
    def find(cls, picture: Picture, noise: PixelNoise, target: Target) -> "CornerPattern | None":
        """Find the inner corners of a chessboard; None where none make a lattice."""
        corners = find_corners(picture, noise)
        lattice = find_lattice(corners, np.ones(len(corners)), target.rows, target.cols)
        return None if lattice is None else cls(lattice, corners[lattice.index])

    def without_marks(self, picture: Picture) -> Picture:
        """Return the picture with the black squares as bright as the white ones."""
        return without_black(picture, self.lattice, self.place_px)

    def cleared(
        self, picture: Picture, noise: PixelNoise, target: Target, stripes: BoardStripes
    ) -> Picture | None:
        """Return None: the squares are out of the stripe's way from the start."""
        return None

    def area(self, target: Target) -> BoardArea:
        """Return where the target may be in the picture."""
        low, high = self.lattice.extent(target.rows, target.cols)
        return BoardArea(self.lattice.picture_from_node, low, high, None)

    def numbered(
        self, picture: Picture, noise: PixelNoise, target: Target, lines: list[StripeLine]
    ) -> SeenTarget | None:
        """Measure the corners, those that the lattice predicts as well, and number them.

        Parameters
        ----------
        picture, noise, target
            As the corners were found with.
        lines
            Stripes across the board.

        Returns
        -------
        SeenTarget or None
            None where the numbering is not certain.
        """
        mine, empty = self.lattice.within_target(target.rows, target.cols)
        node = np.concatenate([self.lattice.node[mine], empty])
        corners = measure_corners(picture, noise, self.lattice, node, lines)
        placed = Placed.of(
            self.lattice,
            node,
            target,
            countable=corners.trusted,
            measurable=corners.trusted,
            centre_px=corners.centre_px,
            sigma_px=corners.sigma_px,
        )
        if placed is None:
            return None
        return SeenTarget(
            placed.place,
            corners.centre_px[placed.index],
            corners.sigma_px[placed.index],
            tuple(corners.cause[i] for i in placed.index),
            placed.picture_from_board,
            None,
        )
