"""Measured points given their places on the target: numbered, inside it, and in agreement."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.seeing.agreement import agreeing
from calib.seeing.lattice import Lattice
from calib.seeing.numbering import inside_target, number
from calib.target import Target


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Those of the points that have a place on the target.

    Attributes
    ----------
    index
        Shape (K,), which of the points.
    place
        Shape (K, 2), their (row, col).
    picture_from_board
        Shape (3, 3), the homography from (row, col) to the picture; good to a pixel or so.
    """

    index: IntArray
    place: IntArray
    picture_from_board: FloatArray

    @classmethod
    def of(
        cls,
        lattice: Lattice,
        node: IntArray,
        target: Target,
        *,
        countable: BoolArray,
        measurable: BoolArray,
        centre_px: FloatArray,
        sigma_px: FloatArray,
    ) -> "Placed | None":
        """Give points of a lattice their places; keep those that lie on the target as others do.

        Parameters
        ----------
        lattice, node
            Their lattice, and shape (N, 2), which of its nodes they are.
        target
            What is in the picture.
        countable
            Shape (N,), points good enough to count rows and columns by.
        measurable
            Shape (N,), points good enough to measure with.
        centre_px, sigma_px
            Shape (N, 2).

        Returns
        -------
        Placed or None
            None where the numbering is not certain, or too few points agree.
        """
        rows, cols = target.rows, target.cols
        numbering = number(node[countable], lattice.picture_from_node, rows, cols)
        if numbering is None:
            return None
        place = numbering.rows_and_cols(node)
        keep = np.flatnonzero(countable & measurable & inside_target(place, rows, cols))
        agreed = agreeing(place[keep], centre_px[keep], sigma_px[keep])
        if agreed is None:
            return None
        homography, agree = agreed
        index = keep[agree]
        return cls(index, place[index], homography)
