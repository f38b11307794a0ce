"""How far apart two sensors place the same pixels."""

import numpy as np

from calib.arrays import FloatArray
from calib.sensor import LaserSensor


def pixel_grid(width: int, height: int, step_px: int = 32) -> FloatArray:
    """Return pixels that cover a picture evenly, row by row.

    Parameters
    ----------
    width, height
        Size of the picture, px.
    step_px
        Distance of neighbours.

    Returns
    -------
    pixels_px
        Shape (N, 2).
    """
    u, v = np.meshgrid(
        np.arange(step_px / 2 - 0.5, width, step_px), np.arange(step_px / 2 - 0.5, height, step_px)
    )
    return np.column_stack([u.ravel(), v.ravel()])


def sheet_difference_mm(one: LaserSensor, other: LaserSensor, pixels_px: FloatArray) -> FloatArray:
    """Return how far two sensors place the points that pixels show from each other.

    Parameters
    ----------
    one, other
        The sensors; both in the frame of the same camera.
    pixels_px
        Shape (N, 2).

    Returns
    -------
    difference_mm
        Shape (N,), length of the difference of the two points; NaN where one of them sees no sheet.
    """
    return np.asarray(np.linalg.norm(one.locate(pixels_px) - other.locate(pixels_px), axis=1))
