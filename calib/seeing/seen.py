"""What of a target is seen in one picture, before it becomes a view."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.homography import apply_homography
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
    light_over_outline
        Radius of the disc that perspective shifts as a dot, over that of its outline.
    """

    place: IntArray
    centre_px: FloatArray
    sigma_px: FloatArray
    cause: tuple[Cause, ...]
    picture_from_board: FloatArray
    outlines: Ellipses | None
    light_over_outline: float = 1.0

    def __len__(self) -> int:
        return len(self.place)

    @property
    def dot_radius(self) -> float | None:
        """Radius of the dots, in pitches, by the areas of their outlines; None for a chessboard.

        Of bells of light it is that of the disc that perspective shifts as much.
        """
        if self.outlines is None:
            return None
        here = self.place.astype(np.float64)
        down, right = (
            apply_homography(self.picture_from_board, here + 0.5 * step)
            - apply_homography(self.picture_from_board, here - 0.5 * step)
            for step in np.eye(2)
        )
        cell_px2 = np.abs(down[:, 0] * right[:, 1] - down[:, 1] * right[:, 0])
        outline = np.median(self.outlines.radius_px / np.sqrt(cell_px2))
        return self.light_over_outline * float(outline)

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
