"""Where dots may be: round spots of either size and brightness, by their outlines."""

import numpy as np

from calib.arrays import BoolArray, FloatArray, Picture
from calib.seeing.ellipse import Ellipses, fit_ellipses
from calib.seeing.noise import PixelNoise
from calib.seeing.resample import Float32Array, sampled, shrunk, smoothed, tops

SMALLEST_RADIUS_PX, LARGEST_RADIUS_PX = 2.5, 45.0

_SHRINK = 4
_RADII_PX = (5.5, 7.5, 10.5, 15.0, 21.0, 29.0, 40.0)
_MOST_SPOTS = 500
_CELL_PX = 8.0
_LARGE_RADIUS_PX = 20.0
_RAYS = 32
_SAMPLES = 26
_REACH = (0.25, 1.9)  # where along a ray the outline is looked for, in expected radii
_ON_OUTLINE = 0.11
_FEWEST_ON_OUTLINE = 0.6
_LONGEST_TO_SHORTEST = 2.6


def find_dots(picture: Picture, noise: PixelNoise, *, dark: bool) -> Ellipses:
    """Find spots with an elliptic outline.

    Parameters
    ----------
    picture
        Shape (H, W).
    noise
        Noise of its pixels.
    dark
        Spots are darker than their ground.

    Returns
    -------
    Ellipses
        Rough outlines, good to about half a pixel, the clearest first. Others than the target's
        dots may be among them, and dots that light spoils may be missing.
    """
    bright = np.uint8(255) - picture if dark else picture
    place, radius = _spots(bright, noise)
    smooth = smoothed(bright, 1.0)
    grain = 0.3 * float(np.sqrt(noise.floor))
    outlines, share = _outlines(smooth, place, radius, grain)
    # Once more from the outline found: the first look may be off by a third of the radius.
    good = np.flatnonzero(share >= 0.5)
    again = outlines.picked(good)
    outlines, share = _outlines(smooth, again.centre_px, again.radius_px, grain)
    good = np.flatnonzero(share >= _FEWEST_ON_OUTLINE)
    good = good[np.argsort(-share[good], kind="stable")]
    return _without_doubles(outlines.picked(good))


def _spots(bright: Picture, noise: PixelNoise) -> tuple[FloatArray, FloatArray]:
    """Return places and radii where the Laplacian of a Gaussian is largest nearby."""
    small = shrunk(shrunk(bright, 2), 2).astype(np.float32)
    smaller = shrunk(small, 2)
    least = max(2.0, 1.5 * float(np.sqrt(noise.floor)))
    places, radii, responses = [], [], []
    for radius in _RADII_PX:
        # Larger spots are looked for in a picture half that size.
        level, shrink = (smaller, 2 * _SHRINK) if radius > _LARGE_RADIUS_PX else (small, _SHRINK)
        sigma = radius / shrink / np.sqrt(2.0)
        response = _spot_response(level, sigma)
        v, u = np.nonzero(tops(response, 1) & (response > least))
        places.append(shrink * np.column_stack([u, v]) + 0.5 * (shrink - 1))
        radii.append(np.full(u.size, radius))
        responses.append(response[v, u])
    strongest = np.argsort(-np.concatenate(responses), kind="stable")
    place, size = np.concatenate(places)[strongest], np.concatenate(radii)[strongest]
    # Of those in one small cell the strongest has the scale that suits.
    cell = np.rint(place / _CELL_PX).astype(np.int64)
    first = np.sort(np.unique(cell[:, 0] * 100_000 + cell[:, 1], return_index=True)[1])
    return place[first[:_MOST_SPOTS]], size[first[:_MOST_SPOTS]]


def _spot_response(small: Float32Array, sigma: float) -> Float32Array:
    """Return -s² times the Laplacian of a Gaussian, in counts, as a difference of two."""
    ratio = 1.3
    inner = smoothed(small, sigma / np.sqrt(ratio))
    outer = smoothed(small, sigma * np.sqrt(ratio))
    return np.asarray((inner - outer) * (2.0 / (ratio - 1.0 / ratio)), dtype=np.float32)


def _outlines(
    smooth: Picture, place: FloatArray, radius: FloatArray, grain: float
) -> tuple[Ellipses, FloatArray]:
    """Fit an ellipse to where brightness falls most along rays from each place.

    Also return the share of rays that agree with it.
    """
    if len(place) == 0:
        return Ellipses.circles(np.empty((0, 2)), np.empty(0)), np.empty(0)
    edge, drop = _steepest_fall(smooth, place, radius)
    strong: BoolArray = drop > np.maximum(0.35 * np.median(drop, axis=1), 4.0 * grain)[:, None]
    angle = np.arange(_RAYS) * (2.0 * np.pi / _RAYS)
    points = edge[:, :, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    middle = np.median(edge, axis=1)[:, None]
    weight = np.exp(-0.5 * ((edge - middle) / (0.3 * middle)) ** 2) * strong
    for _ in range(4):
        fit = fit_ellipses(points, weight + 1e-6)
        off = np.abs(fit.level(points - fit.centre_px[:, None]) - 1.0)
        off = np.where(np.isfinite(off), off, 9.0)
        weight = 1.0 / (1.0 + (off / (0.5 * _ON_OUTLINE)) ** 2) ** 2 * strong
    share = ((off < _ON_OUTLINE) & strong).mean(axis=1)
    axes = fit.axes_px
    with np.errstate(invalid="ignore"):
        sound = (
            (axes[:, 1] <= _LONGEST_TO_SHORTEST * axes[:, 0])
            & (fit.radius_px >= SMALLEST_RADIUS_PX)
            & (fit.radius_px <= LARGEST_RADIUS_PX)
            & (np.abs(fit.centre_px).max(axis=1) <= radius)
        )
    return Ellipses(fit.centre_px + place, fit.form), np.where(sound, share, 0.0)


def _steepest_fall(
    smooth: Picture, place: FloatArray, radius: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return per place and ray, shape (N, RAYS), where brightness falls most, px, and how far."""
    angle = np.arange(_RAYS) * (2.0 * np.pi / _RAYS)
    along = np.linspace(*_REACH, _SAMPLES)
    reach = radius[:, None, None] * along
    u = place[:, 0, None, None] + reach * np.cos(angle)[:, None]
    v = place[:, 1, None, None] + reach * np.sin(angle)[:, None]
    samples = sampled(smooth, u, v)
    fall = samples[:, :, :-3] - samples[:, :, 3:]
    best = fall.argmax(axis=2)
    drop = np.take_along_axis(fall, best[:, :, None], axis=2)[:, :, 0]
    # A soft spot falls over a third of its radius: the middle of the fall is steadier than its top.
    about = np.clip(best[:, :, None] + np.arange(-3, 4), 0, fall.shape[2] - 1)
    excess = np.take_along_axis(fall, about, axis=2) - 0.6 * drop[:, :, None]
    weight = np.maximum(excess, 0.0) + 1e-6
    middle = (weight * about).sum(axis=2) / weight.sum(axis=2)
    step = (_REACH[1] - _REACH[0]) / (_SAMPLES - 1)
    return radius[:, None] * (_REACH[0] + (middle + 1.5) * step), drop.astype(np.float64)


def _without_doubles(dots: Ellipses) -> Ellipses:
    """Keep the first of outlines that lie on one another."""
    distance = np.linalg.norm(dots.centre_px[:, None] - dots.centre_px[None], axis=2)
    radius = dots.radius_px
    close: BoolArray = distance < 0.8 * np.minimum(radius[:, None], radius)
    keep = np.ones(len(dots), dtype=bool)
    for i in range(1, len(dots)):
        keep[i] = not (close[i, :i] & keep[:i]).any()
    return dots.picked(keep)
