"""Dots without an edge: bare lamps and dots far out of focus, whose light reaches far and mixes."""

from dataclasses import replace

import numpy as np

from calib.arrays import FloatArray, IntArray, Picture
from calib.seeing import disc
from calib.seeing.ellipse import Ellipses
from calib.seeing.noise import SATURATED_FROM
from calib.seeing.patches import Patches
from calib.seeing.resample import Float32Array, sampled

SOFT_FROM_PX = 2.5
"""Blur from which the window of a sharp edge, three blurs to either side, is too narrow."""

_REACH = 2.5  # blurs
_ROOT_TWO_PI = float(np.sqrt(2.0 * np.pi))
# By how much a disc of the shape fitted looks blurred, and is: parts of where it is steepest.
_SEEN = (0.0, 0.3, 0.42, 0.49, 0.53, 0.553, 0.565)
_TRUE = (0.0, 0.29, 0.42, 0.53, 0.63, 0.71, 0.78)
_ENOUGH_DOTS = 12
_RAYS = 16
_LEVELS = np.linspace(0.0, 2.0, 41)
_NEIGHBOURS = 8
_BELL = 0.6  # blur over radius: a lens so far out of focus would show no stripe
_LIGHT_ENDS = 4.0  # blurs beyond an outline


def blur_px(picture: Picture, outlines: Ellipses) -> float:
    """Return the blur of a picture's dots, the median, px, at least that of the sampling.

    The edge of a disc falls by ``height / (sqrt(2 pi) blur)`` a pixel where it is steepest.
    """
    if len(outlines) == 0:
        return 0.0
    outlines = outlines.picked(np.arange(0, len(outlines), max(1, len(outlines) // _ENOUGH_DOTS)))
    profile = _profiles(picture, outlines)
    step_px = (_LEVELS[1] - _LEVELS[0]) * outlines.radius_px
    fall = np.abs(profile[:, 3:] - profile[:, :-3]).max(axis=1) / (3.0 * step_px)
    height = np.ptp(profile, axis=1)
    seen = height / (_ROOT_TWO_PI * np.maximum(fall, 1e-3)) / outlines.radius_px
    return float(np.median(np.interp(seen, _SEEN, _TRUE) * outlines.radius_px))


def light_over_outline(parameters: FloatArray) -> float:
    """Return the radius of the disc that perspective shifts as much, over that of the outlines.

    Seen at an angle, the rings of a bell of light lie aside of each other, the wider ones more,
    by the square of their radii. The fit weighs a ring by its length and the square of its slope.
    For a disc, sharp or out of focus, the answer is 1: a lens's blur moves nothing.

    Parameters
    ----------
    parameters
        Shape (N, disc.COUNT), of fits of one picture's dots.
    """
    if len(parameters) == 0:
        return 1.0
    radius = disc.outlines(parameters, np.zeros(2)).radius_px
    blur = float(np.median(parameters[:, disc.BLUR] / radius))
    if blur < _BELL:
        return 1.0
    r = np.linspace(0.0, 1.0 + _LIGHT_ENDS * blur, 200)
    bent = np.hypot(r, blur)
    weight = r * (np.exp(-0.5 * ((1.0 - bent) / blur) ** 2) * r / bent) ** 2
    return float(np.sqrt((weight * r * r).sum() / weight.sum()))


def edge_reach_px(outlines: Ellipses, blur: float) -> float:
    """Return how far from soft outlines pixels tell of them: not beyond half way to the next."""
    apart = np.linalg.norm(outlines.centre_px[:, None] - outlines.centre_px[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    half_gap = 0.5 * apart.min(axis=1) - outlines.radius_px
    return float(min(_REACH * blur, np.median(half_gap)))


def without_neighbours(patches: Patches, parameters: FloatArray) -> Patches:
    """Take the light of the dots around off each window, as the dots' own fits tell it.

    Parameters
    ----------
    patches
        N windows.
    parameters
        Shape (N, disc.COUNT), of the dots in them.
    """
    place = parameters[:, :2] + patches.origin
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    near = np.argsort(apart, axis=1)[:, :_NEIGHBOURS]
    samples = patches.samples.copy()
    for rank in range(near.shape[1]):
        other = near[:, rank]
        moved = parameters[other].copy()
        moved[:, :2] = place[other] - patches.origin
        # Slopes hold near a dot; carried on they would lead anywhere.
        moved[:, disc.HEIGHT_U :] = 0.0
        samples -= _own_light(moved, patches.offset)
    return replace(patches, samples=samples)


def without_dots(picture: Picture, parameters: FloatArray, origin: IntArray) -> Picture:
    """Take dots off a picture, as far as their fits tell them; what is clipped stays clipped.

    Parameters
    ----------
    picture
        Shape (H, W).
    parameters, origin
        Shapes (N, disc.COUNT) and (N, 2), of the dots.
    """
    outlines = disc.outlines(parameters, origin.astype(np.float64))
    widest = outlines.axes_px[:, 1] + _LIGHT_ENDS * parameters[:, disc.BLUR]
    height, width = picture.shape
    light = np.zeros(picture.shape, dtype=np.float32)
    for one, middle, reach in zip(parameters, origin, np.ceil(widest).astype(int), strict=True):
        (u0, v0), (u1, v1) = np.maximum(middle - reach, 0), middle + reach + 1
        u, v = np.meshgrid(np.arange(u0, min(u1, width)), np.arange(v0, min(v1, height)))
        offset = np.column_stack([u.ravel(), v.ravel()]) - middle
        light[v0:v1, u0:u1] += _own_light(one[None], offset).reshape(u.shape)
    left = np.clip(np.rint(picture - light), 0.0, 255.0).astype(np.uint8)
    return np.where(picture >= SATURATED_FROM, picture, left)


def _own_light(parameters: FloatArray, offset: IntArray) -> Float32Array:
    """Return what dots add to their ground at pixels, shape (N, K)."""
    own = parameters.copy()
    own[:, disc.GROUND : disc.HEIGHT] = 0.0
    light, _ = disc.evaluate(own.astype(np.float32), offset.astype(np.float32))
    return np.asarray(light, dtype=np.float32)


def _profiles(picture: Picture, outlines: Ellipses) -> FloatArray:
    """Return brightness from the centre outwards, at `_LEVELS`, medians over directions."""
    angle = np.arange(_RAYS) * (2.0 * np.pi / _RAYS)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    length = 1.0 / outlines.level(np.broadcast_to(direction, (len(outlines), _RAYS, 2)))
    reach = length[:, :, None] * _LEVELS
    u, v = (
        outlines.centre_px[:, axis, None, None] + reach * direction[:, axis, None]
        for axis in (0, 1)
    )
    return np.asarray(np.median(sampled(picture, u, v), axis=1), dtype=np.float64)
