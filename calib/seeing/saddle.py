"""The picture of a chessboard's inner corner: four squares, blurred, on a sloping ground."""

import numpy as np
from scipy.special import ndtr

from calib.arrays import FloatArray

U, V = 0, 1
ANGLE_1, ANGLE_2 = 2, 3
BLUR = 4
GROUND, GROUND_U, GROUND_V = 5, 6, 7
HEIGHT = 8
COUNT = 9
"""The place of each parameter; see `evaluate`."""

_NARROWEST_BLUR_PX, _WIDEST_BLUR_PX = 0.3, 5.0
_LARGEST_TURN = 0.2  # rad a step


def start(
    centre_px: FloatArray, origin: FloatArray, edges_px: FloatArray, blur_px: float
) -> FloatArray:
    """Return first parameters, shape (N, COUNT).

    `edges_px`, shape (N, 2, 2), are the directions of the two edges. The brightness is left at
    zero: `evaluate` is linear in it, and the first step finds it.
    """
    parameters = np.zeros((len(centre_px), COUNT))
    parameters[:, :2] = centre_px - origin
    # The angle is that of an edge's normal.
    parameters[:, ANGLE_1] = np.arctan2(edges_px[:, 0, 0], -edges_px[:, 0, 1])
    parameters[:, ANGLE_2] = np.arctan2(edges_px[:, 1, 0], -edges_px[:, 1, 1])
    parameters[:, BLUR] = blur_px
    return parameters


def evaluate(parameters: FloatArray, offset_px: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Return the brightness of corners and its derivatives.

    Parameters
    ----------
    parameters
        Shape (N, COUNT): centre, angles of the two edges' normals, blur of the edges (standard
        deviation, px), mean brightness and its slopes, half the contrast of the squares.
    offset_px
        Shape (K, 2), places from each corner's origin.

    Returns
    -------
    brightness, jacobian
        Shapes (N, K) and (N, COUNT, K), counts, before the sensor clips.

    Notes
    -----
    ``ground + height * e(d1) * e(d2)``, with d the distances from the two edges and
    ``e(d) = 2 Phi(d / blur) - 1``.
    """
    u, v = offset_px.T
    x, y = u - parameters[:, U, None], v - parameters[:, V, None]
    blur, height = parameters[:, BLUR, None], parameters[:, HEIGHT, None]
    jacobian = np.empty((len(parameters), COUNT, len(u)), dtype=parameters.dtype)
    sides, slopes, normals = [], [], []
    for column in (ANGLE_1, ANGLE_2):
        cos, sin = np.cos(parameters[:, column, None]), np.sin(parameters[:, column, None])
        d = (x * cos + y * sin) / blur
        sides.append(2.0 * ndtr(d) - 1.0)
        slopes.append(np.float32(np.sqrt(2.0 / np.pi)) * np.exp(-0.5 * d * d) / blur)
        normals.append((cos, sin, y * cos - x * sin, d))
    rise_1, rise_2 = height * slopes[0] * sides[1], height * sides[0] * slopes[1]
    (cos_1, sin_1, turn_1, d_1), (cos_2, sin_2, turn_2, d_2) = normals
    jacobian[:, U] = -rise_1 * cos_1 - rise_2 * cos_2
    jacobian[:, V] = -rise_1 * sin_1 - rise_2 * sin_2
    jacobian[:, ANGLE_1], jacobian[:, ANGLE_2] = rise_1 * turn_1, rise_2 * turn_2
    jacobian[:, BLUR] = -rise_1 * d_1 - rise_2 * d_2
    linear = np.stack([np.ones_like(u), u, v])
    jacobian[:, GROUND:HEIGHT] = linear
    jacobian[:, HEIGHT] = sides[0] * sides[1]
    ground = parameters[:, GROUND:HEIGHT] @ linear
    return ground + height * jacobian[:, HEIGHT], jacobian


def sound(parameters: FloatArray, before: FloatArray) -> FloatArray:
    """Return parameters after a step, kept near what they were."""
    step = parameters - before
    step[:, :2] = np.clip(step[:, :2], -1.5, 1.5)
    step[:, ANGLE_1 : ANGLE_2 + 1] = np.clip(
        step[:, ANGLE_1 : ANGLE_2 + 1], -_LARGEST_TURN, _LARGEST_TURN
    )
    now = before + step
    blur = np.clip(now[:, BLUR], 0.6 * before[:, BLUR], 1.6 * before[:, BLUR])
    now[:, BLUR] = np.clip(blur, _NARROWEST_BLUR_PX, _WIDEST_BLUR_PX)
    return now
