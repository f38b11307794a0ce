"""The picture of a disc: a domed ellipse with a blurred edge, on a sloping ground, clipped."""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from calib.arrays import FloatArray
from calib.seeing.ellipse import Ellipses

U, V = 0, 1
Q11, Q12, Q22 = 2, 3, 4
BLUR = 5
GROUND, GROUND_U, GROUND_V = 6, 7, 8
HEIGHT, HEIGHT_U, HEIGHT_V, DOME = 9, 10, 11, 12
COUNT = 13
"""The place of each parameter; see `evaluate`."""

_ROOT_TWO_PI = float(np.sqrt(2.0 * np.pi))
_NARROWEST_BLUR_PX, _WIDEST_BLUR_PX = 0.3, 16.0
_BRIGHTEST, _STEEPEST = 2000.0, 60.0  # counts, counts / px
_MOST_UNEVEN = 0.25  # change of a dot's height over a radius, of the height


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
    place = _inward(parameters, offset_px)
    return np.asarray(place.reach * (1.0 - place.level))


def evaluate(parameters: FloatArray, offset_px: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Return the brightness of discs and its derivatives.

    Parameters
    ----------
    parameters
        Shape (N, COUNT): centre, form of the ellipse, blur of the edge (standard deviation, px),
        brightness of the ground and its slopes, height over the ground, its slopes and its
        bending (a diffuser over one lamp is brighter in its middle), counts / px^2.
    offset_px
        Shape (K, 2), places from each disc's origin.

    Returns
    -------
    brightness, jacobian
        Shapes (N, K) and (N, COUNT, K), counts, before the sensor clips.

    Notes
    -----
    ``ground + height * Phi((R - sqrt(r^2 + blur^2)) / blur)``: r and R are the distances of a
    place and of the outline from the centre, ``R - r`` to first order that inwards from the
    ellipse, Phi the normal distribution. A Gaussian lens gathers at r from the disc what a Rice
    law holds below R; its mean is about the root, its deviation about the blur. A sharp disc has
    the edge of a half-plane, drawn in by ``blur^2 / 2R`` as an outline that bends is; one with
    ``blur = R`` is a bell to 0.1 % of its height. The derivatives by centre and form hold near
    the outline, where alone they are not zero.
    """
    place = _inward(parameters, offset_px)
    x, y = place.x, place.y
    blur = parameters[:, BLUR, None]
    # One mean radius does: by how much a flat outline bends less on one side is no matter here.
    mean_form = 0.5 * (parameters[:, Q11, None] + parameters[:, Q22, None])
    bent = np.sqrt(place.level * place.level + blur * blur * mean_form)
    s, share = place.reach * (1.0 - bent), place.level / bent
    linear = np.stack([np.ones(len(offset_px), dtype=parameters.dtype), *offset_px.T])
    inside = ndtr(s / blur)
    uneven = np.concatenate([linear, (linear[1:] ** 2).sum(axis=0, keepdims=True)])
    height = parameters[:, HEIGHT:] @ uneven
    edge = height * np.exp(-0.5 * (s / blur) ** 2) / (np.float32(_ROOT_TWO_PI) * blur)
    jacobian = np.empty((len(parameters), COUNT, len(offset_px)), dtype=parameters.dtype)
    per_length = edge * (share / place.length)
    jacobian[:, U], jacobian[:, V] = per_length * place.qx, per_length * place.qy
    # The gradient of the level is (Q d) / level: half of what the form's entries need.
    jacobian[:, Q11] = -0.5 * per_length * x * x
    jacobian[:, Q12] = -per_length * x * y
    jacobian[:, Q22] = -0.5 * per_length * y * y
    jacobian[:, BLUR] = -edge * (s / blur + place.reach * (blur * mean_form) / bent)
    jacobian[:, GROUND:HEIGHT] = linear
    jacobian[:, HEIGHT:] = inside[:, None, :] * uneven
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
    # In a window that is clipped all over nothing holds the brightness.
    bright = now[:, [GROUND, HEIGHT]]
    now[:, [GROUND, HEIGHT]] = np.clip(bright, -_BRIGHTEST, _BRIGHTEST)
    steepest = _MOST_UNEVEN * np.abs(now[:, HEIGHT, None]) / radius[:, None]
    now[:, HEIGHT_U:DOME] = np.clip(now[:, HEIGHT_U:DOME], -steepest, steepest)
    roundest = steepest / radius[:, None]
    now[:, DOME:] = np.clip(now[:, DOME:], -roundest, roundest)
    slopes = now[:, GROUND_U : GROUND_V + 1]
    now[:, GROUND_U : GROUND_V + 1] = np.clip(slopes, -_STEEPEST, _STEEPEST)
    return now


class _Place(NamedTuple):
    """Places seen from each ellipse, all of shape (N, K)."""

    x: FloatArray  # from the centre
    y: FloatArray
    qx: FloatArray  # the form's matrix times (x, y), which points outwards
    qy: FloatArray
    length: FloatArray  # of (qx, qy)
    level: FloatArray  # 1 on the outline, 0 in the centre
    reach: FloatArray  # from the centre to the outline, across it, px


def _inward(parameters: FloatArray, offset_px: FloatArray) -> _Place:
    x = offset_px[:, 0] - parameters[:, U, None]
    y = offset_px[:, 1] - parameters[:, V, None]
    q11, q12, q22 = (parameters[:, i, None] for i in (Q11, Q12, Q22))
    qx, qy = q11 * x + q12 * y, q12 * x + q22 * y
    level = np.sqrt(np.maximum(qx * x + qy * y, 1e-9))
    length = np.maximum(np.sqrt(qx * qx + qy * qy), 1e-9)
    return _Place(x, y, qx, qy, length, level, level / length)
