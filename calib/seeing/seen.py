"""What of a target is seen in one picture, before it becomes a view."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.seeing.ellipse import Ellipses
from calib.seeing.stripe_on_board import BoardArea
from calib.target import Target
from calib.views import Cause, TargetPoints


@dataclass(frozen=True, slots=True, eq=False)
class SeenTarget:
    """Numbered points, and the rough map from the board to the picture.

    Attributes
    ----------
    place
        Shape (N, 2), (row, col).
    centre_px, sigma_px
        Shape (N, 2).
    cause
        N entries.
    picture_from_board
        Shape (3, 3), the homography from (row, col) to the picture; good to a pixel or so.
    outlines
        The N dots' outlines; None for a chessboard.
    """

    place: IntArray
    centre_px: FloatArray
    sigma_px: FloatArray
    cause: tuple[Cause, ...]
    picture_from_board: FloatArray
    outlines: Ellipses | None

    def __len__(self) -> int:
        return len(self.place)

    def area(self, target: Target) -> BoardArea:
        """Return where the target is in the picture."""
        return BoardArea(
            self.picture_from_board,
            np.zeros(2, dtype=np.int64),
            np.array([target.rows - 1, target.cols - 1]),
            self.outlines,
        )

    def sorted_points(self) -> TargetPoints:
        """Return the points row by row."""
        order = np.lexsort((self.place[:, 1], self.place[:, 0]))
        return TargetPoints(
            row=self.place[order, 0],
            col=self.place[order, 1],
            centre_px=self.centre_px[order],
            sigma_px=self.sigma_px[order],
            cause=tuple(self.cause[i] for i in order),
        )
