"""The picture of a chessboard's inner corner: four squares, blurred, on a sloping ground."""

import numpy as np
from scipy.special import ndtr

from calib.arrays import FloatArray

U, V = 0, 1
ANGLE_1, ANGLE_2 = 2, 3
BLUR = 4
GROUND, GROUND_U, GROUND_V = 5, 6, 7
HEIGHT = 8
SHRINK = 9
COUNT = 10
"""The place of each parameter; see `evaluate`."""

_NARROWEST_BLUR_PX, _WIDEST_BLUR_PX = 0.3, 5.0
_LARGEST_TURN = 0.2  # rad a step
_MOST_SHRINK_PX = 2.0
_DENSITY = float(1.0 / np.sqrt(2.0 * np.pi))


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
        deviation, px), mean brightness and its slopes, half the contrast of the squares, how
        far ink, bloom or a curved response has moved every edge into the first squares, px.
    offset_px
        Shape (K, 2), places from each corner's origin.

    Returns
    -------
    brightness, jacobian
        Shapes (N, K) and (N, COUNT, K), counts, before the sensor clips.

    Notes
    -----
    ``ground + height * (2 F - 1)``, with F the share of the first two squares, those on the
    like sides of both edges: ``F = Phi(a - t) Phi(b - t) + Phi(-a - t) Phi(-b - t)``, with a, b
    the distances from the two edges and t the shrinking, over the blur. A negative t is that of
    the other two squares.
    """
    u, v = offset_px.T
    x, y = u - parameters[:, U, None], v - parameters[:, V, None]
    blur, height = parameters[:, BLUR, None], parameters[:, HEIGHT, None]
    shrink = np.abs(parameters[:, SHRINK, None]) / blur
    first = np.where(parameters[:, SHRINK, None] < 0.0, -1.0, 1.0).astype(parameters.dtype)
    (cos_1, sin_1, turn_1, d_1), (cos_2, sin_2, turn_2, d_2) = (
        _edge(parameters[:, column, None], x, y, blur) for column in (ANGLE_1, ANGLE_2)
    )
    # Of the other two squares one lies on the unlike side of the second edge.
    share, by_1, by_2, by_shrink = _squares(d_1, first * d_2, shrink)
    by_2, twice = first * by_2, 2.0 * first * height
    rise_1, rise_2 = twice * by_1 / blur, twice * by_2 / blur
    jacobian = np.empty((len(parameters), COUNT, len(u)), dtype=parameters.dtype)
    jacobian[:, U] = -rise_1 * cos_1 - rise_2 * cos_2
    jacobian[:, V] = -rise_1 * sin_1 - rise_2 * sin_2
    jacobian[:, ANGLE_1], jacobian[:, ANGLE_2] = rise_1 * turn_1, rise_2 * turn_2
    narrowed = twice * by_shrink / blur
    jacobian[:, BLUR] = -rise_1 * d_1 - rise_2 * d_2 - narrowed * shrink
    linear = np.stack([np.ones_like(u), u, v])
    jacobian[:, GROUND:HEIGHT] = linear
    jacobian[:, HEIGHT] = first * (2.0 * share - 1.0)
    jacobian[:, SHRINK] = first * narrowed
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
    now[:, SHRINK] = np.clip(now[:, SHRINK], -_MOST_SHRINK_PX, _MOST_SHRINK_PX)
    return now


def _edge(
    angle: FloatArray, x: FloatArray, y: FloatArray, blur: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return an edge's normal, places along it, and their distances from it over the blur."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cos, sin, y * cos - x * sin, (x * cos + y * sin) / blur


def _squares(
    a: FloatArray, b: FloatArray, shrink: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the share of two squares opposite each other, and its derivatives by a, b, shrink."""
    near_a, near_b, far_a, far_b = (ndtr(s * d - shrink) for s in (1.0, -1.0) for d in (a, b))
    top = np.float32(_DENSITY)
    rise_a, rise_b, fall_a, fall_b = (
        top * np.exp(-0.5 * (s * d - shrink) ** 2) for s in (1.0, -1.0) for d in (a, b)
    )
    by_a = rise_a * near_b - fall_a * far_b
    by_b = near_a * rise_b - far_a * fall_b
    by_shrink = -(rise_a * near_b + near_a * rise_b + fall_a * far_b + far_a * fall_b)
    return near_a * near_b + far_a * far_b, by_a, by_b, by_shrink
