"""The straight line in which a laser sheet crosses the target."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, LightPlane, RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """A line on the board, in TCF.

    Attributes
    ----------
    nearest_mm
        Shape (2,): its point nearest to the place it was asked for.
    direction
        Shape (2,), unit, with a component along +x, or along +y where it has none along x.
    """

    nearest_mm: FloatArray
    direction: FloatArray


def crossing_on_board(
    plane: LightPlane, cam_from_board: RigidTransform, near_mm: FloatArray
) -> Crossing | None:
    """Return where a sheet crosses the plane of the board; None where the two are parallel.

    Parameters
    ----------
    plane
        The sheet, camera frame.
    cam_from_board
        Pose of the board.
    near_mm
        Shape (2,), TCF: the place whose nearest point of the line is wanted.
    """
    normal_in_board = cam_from_board.rotation.T @ plane.normal_in_cam
    offset = float(plane.distance_mm(cam_from_board.translation_mm[None])[0])
    steepness = float(np.linalg.norm(normal_in_board[:2]))
    if not steepness > 1e-6:
        return None
    across = normal_in_board[:2] / steepness
    nearest = near_mm - (across @ near_mm + offset / steepness) * across
    direction = np.array([across[1], -across[0]])
    if direction[0] < 0.0 or (direction[0] == 0.0 and direction[1] < 0.0):
        direction = -direction
    return Crossing(nearest, direction)
