"""The picture of a disc: an ellipse with a blurred edge, on a sloping ground, clipped."""

import numpy as np
from scipy.special import ndtr

from calib.arrays import FloatArray
from calib.ellipse import Ellipses

U, V = 0, 1
Q11, Q12, Q22 = 2, 3, 4
BLUR = 5
GROUND, GROUND_U, GROUND_V = 6, 7, 8
HEIGHT, HEIGHT_U, HEIGHT_V = 9, 10, 11
COUNT = 12
"""The place of each parameter; see `evaluate`."""

_NARROWEST_BLUR_PX, _WIDEST_BLUR_PX = 0.3, 8.0


def start(outlines: Ellipses, origin: FloatArray, blur_px: float) -> FloatArray:
    """Return first parameters, shape (N, COUNT), of discs with these outlines.

    `origin`, shape (N, 2), is the pixel that each disc's coordinates are counted from. The
    brightness is left at zero: `evaluate` is linear in it.
    """
    parameters = np.zeros((len(outlines), COUNT))
    parameters[:, :2] = outlines.centre_px - origin
    parameters[:, Q11 : Q22 + 1] = outlines.form
    parameters[:, BLUR] = blur_px
    return parameters


def outlines(parameters: FloatArray, origin: FloatArray) -> Ellipses:
    """Return the ellipses that parameters describe, in the picture."""
    return Ellipses(parameters[:, :2] + origin, parameters[:, Q11 : Q22 + 1])


def inward_px(parameters: FloatArray, offset_px: FloatArray) -> FloatArray:
    """Return how far points, shape (K, 2), lie inside each outline, px to first order, (N, K)."""
    return _inward(parameters, offset_px)[0]


def evaluate(parameters: FloatArray, offset_px: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Return the brightness of discs and its derivatives.

    Parameters
    ----------
    parameters
        Shape (N, COUNT): centre, form of the ellipse, blur of the edge (standard deviation, px),
        brightness of the ground and its slopes, height over the ground and its slopes.
    offset_px
        Shape (K, 2), places from each disc's origin.

    Returns
    -------
    brightness, jacobian
        Shapes (N, K) and (N, COUNT, K), counts, before the sensor clips.

    Notes
    -----
    ``ground + height * Phi(s / blur)``: s is the distance inwards from the ellipse to first
    order, Phi the normal distribution: the edge of a half-plane seen by a Gaussian lens. The
    derivatives by centre and form hold near the outline, where alone they are not zero.
    """
    s, pull_u, pull_v, x, y = _inward(parameters, offset_px)
    blur = parameters[:, BLUR, None]
    u, v = offset_px.T
    linear = np.stack([np.ones_like(u), u, v])
    inside = ndtr(s / blur)
    height = parameters[:, HEIGHT:] @ linear
    edge = height * np.exp(-0.5 * (s / blur) ** 2) / (np.sqrt(2.0 * np.pi) * blur)
    jacobian = np.empty((len(parameters), COUNT, len(u)))
    jacobian[:, U], jacobian[:, V] = edge * pull_u, edge * pull_v
    # The gradient of the level is (Q d) / level: half of what the form's entries need.
    per_form = -0.5 * edge / np.maximum(_steepness(parameters, x, y), 1e-9)
    jacobian[:, Q11] = per_form * x * x
    jacobian[:, Q12] = 2.0 * per_form * x * y
    jacobian[:, Q22] = per_form * y * y
    jacobian[:, BLUR] = -edge * s / blur
    jacobian[:, GROUND:HEIGHT] = linear
    jacobian[:, HEIGHT:] = inside[:, None, :] * linear
    return parameters[:, GROUND:HEIGHT] @ linear + height * inside, jacobian


def sound(parameters: FloatArray, before: FloatArray) -> FloatArray:
    """Return parameters after a step, kept near what they were: a disc of like size."""
    now = parameters.copy()
    scale = np.sqrt(0.5 * (before[:, Q11] + before[:, Q22]))
    radius = 1.0 / scale
    now[:, :2] = before[:, :2] + np.clip(
        now[:, :2] - before[:, :2], -0.3 * radius[:, None], 0.3 * radius[:, None]
    )
    q11, q12, q22 = now[:, Q11], now[:, Q12], now[:, Q22]
    was = before[:, Q11] * before[:, Q22] - before[:, Q12] ** 2
    determinant = q11 * q22 - q12**2
    wild = ~((q11 > 0.0) & (determinant > 0.4 * was) & (determinant < 2.5 * was))
    now[wild, Q11 : Q22 + 1] = before[wild, Q11 : Q22 + 1]
    blur = np.clip(now[:, BLUR], 0.6 * before[:, BLUR], 1.6 * before[:, BLUR])
    now[:, BLUR] = np.clip(blur, _NARROWEST_BLUR_PX, _WIDEST_BLUR_PX)
    return now


def _inward(parameters: FloatArray, offset_px: FloatArray) -> tuple[FloatArray, ...]:
    """Return distance inwards, its derivatives by the centre, and places from the centre."""
    x = offset_px[:, 0] - parameters[:, U, None]
    y = offset_px[:, 1] - parameters[:, V, None]
    q11, q12, q22 = (parameters[:, i, None] for i in (Q11, Q12, Q22))
    gu, gv = q11 * x + q12 * y, q12 * x + q22 * y
    level = np.sqrt(np.maximum(gu * x + gv * y, 1e-12))
    length = np.maximum(np.hypot(gu, gv), 1e-12)
    return (1.0 - level) * level / length, gu / length, gv / length, x, y


def _steepness(parameters: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return |Q d|, which is level times the level's gradient."""
    q11, q12, q22 = (parameters[:, i, None] for i in (Q11, Q12, Q22))
    return np.hypot(q11 * x + q12 * y, q12 * x + q22 * y)
