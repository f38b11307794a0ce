"""A board before a camera."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, RigidTransform, Target
from station.scenes.board import checked_shifts, outline_mm

_LEAST_SINE = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class PlacedBoard:
    """A board in a camera's frame.

    Attributes
    ----------
    target
        Its points as they should be.
    cam_from_board
        Its pose.
    dot_shift_mm
        Shape (rows * cols, 2): how far each dot is from where it should be on the board, as no
        printer puts them exactly; None: nowhere.
    lit
        Whether its lamps shine; printed boards have none.

    Raises
    ------
    ValueError
        If dots are displaced so far that they may touch.
    """

    target: Target
    cam_from_board: RigidTransform
    dot_shift_mm: FloatArray | None = None
    lit: bool = True

    def __post_init__(self) -> None:
        if self.dot_shift_mm is not None:
            shifts = checked_shifts(self.target, self.dot_shift_mm)
            object.__setattr__(self, "dot_shift_mm", shifts)

    @property
    def corners_in_cam_mm(self) -> FloatArray:
        """Corners of the board, in order round it, shape (4, 3)."""
        return self.cam_from_board.apply(corners_mm(self.target))

    @property
    def shows_its_front(self) -> bool:
        """All of it lies before the camera, its points on the side that the camera sees."""
        facing = float(self.cam_from_board.rotation[:, 2] @ self.cam_from_board.translation_mm)
        return bool(self.corners_in_cam_mm[:, 2].min() > 0.0 and facing > 0.0)

    @property
    def is_edge_on(self) -> bool:
        """Some of it is seen from less than 6 degrees: next to nothing comes from there.

        Beyond, the horizon of its plane comes into the picture, where no ray meets it.
        """
        corners = self.corners_in_cam_mm
        sine = corners @ self.cam_from_board.rotation[:, 2] / np.linalg.norm(corners, axis=1)
        return bool(sine.min() < _LEAST_SINE)


def corners_mm(target: Target) -> FloatArray:
    """Return the corners of a target's board in TCF, in order round it, shape (4, 3)."""
    (left, top), (right, bottom) = outline_mm(target)
    corners = [[left, top, 0], [right, top, 0], [right, bottom, 0], [left, bottom, 0]]
    return np.array(corners, dtype=np.float64)
