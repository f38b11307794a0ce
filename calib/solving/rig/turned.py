"""A board numbered from another corner: a grid of points looks the same after half a turn.

A square one does so after each quarter. A numbering turned by n quarters makes of the board's
frame another one, turned about the middle of the board.
"""

from dataclasses import replace

import numpy as np

from calib.rigid import RigidTransform
from calib.target import Target
from calib.views import View


def numberings(target: Target) -> tuple[int, ...]:
    """Return the quarter turns after which a board looks the same."""
    return (0, 1, 2, 3) if target.rows == target.cols else (0, 2)


def board_from_turned(target: Target, quarters: int) -> RigidTransform:
    """Return the map from the frame of a board so numbered to that of the board."""
    middle = target.points_mm.mean(axis=0)
    turn = RigidTransform.from_rotation_vector([0.0, 0.0, quarters * np.pi / 2.0], np.zeros(3))
    return RigidTransform(turn.rotation, middle - turn.rotation @ middle)


def board_from_middle(target: Target) -> RigidTransform:
    """Return the map from a frame like the board's at its middle to that of the board."""
    return RigidTransform(np.eye(3), target.points_mm.mean(axis=0))


def turned_view(view: View, target: Target, quarters: int) -> View:
    """Return a view, numbered by so many quarters off, with the numbers of the board."""
    row, col = view.points.row, view.points.col
    if quarters % 2:
        row, col = col, target.cols - 1 - row
    if quarters >= 2:
        row, col = target.rows - 1 - row, target.cols - 1 - col
    return replace(view, points=replace(view.points, row=row, col=col))
