"""Where a stripe may be: ridges of the picture at a fraction of its size and at half that."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import PixelNoise
from calib.seeing.resample import Float32Array, shrunk
from calib.seeing.ridge import Ridge, gaussian_rows, inside
from calib.seeing.stripe_order import order_along

_SHRINK, _SHRINK_SMALL = 4, 2
"""A stripe 1.5 to 8 px wide becomes one of 0.4 to 2, and its noise falls to a quarter. In a small
picture stripes are thinner."""

_SMALL_SIDE_PX = 1300
_KERNEL = 1.1
_LINE_LIKE = 0.55
_DIP_LIKE = 0.85  # where a line is dim for a few pixels it curves upwards along itself
_WEAK_SIGMAS = 4.0
_STRONG_SIGMAS = 10.0
_MOST_POINTS = 10_000
_HALF_PIXEL = 0.62  # a little more than 0.5, so that a ridge between two pixels is not lost

# A second difference smooths as well, by 1 / 6 px^2 along itself.
_ROW = gaussian_rows(np.sqrt(_KERNEL**2 - 1.0 / 6.0), np.zeros(1))[0, 0].astype(np.float32)
_CURVATURE_NOISE = float(np.linalg.norm(_ROW) * np.linalg.norm(np.convolve(_ROW, [1, -2, 1])))


@dataclass(frozen=True, slots=True, eq=False)
class StripeSeeds:
    """Places near a ridge, in groups that lie side by side along it.

    Attributes
    ----------
    place_px
        Shape (G, S, 2), in the full picture, about a pixel apart; S is the group's size.
    normal
        Shape (G, 2).

    Groups are sorted: ridge by ridge, along the longer side of each.
    """

    place_px: FloatArray
    normal: FloatArray

    def __len__(self) -> int:
        return len(self.place_px)

    @property
    def group(self) -> int:
        """Number of places in a group."""
        return int(self.place_px.shape[1])

    def picked(self, index: IntArray) -> "StripeSeeds":
        """Return the groups an index array picks."""
        return StripeSeeds(self.place_px[index], self.normal[index])


@dataclass(frozen=True, slots=True, eq=False)
class _CoarsePoints:
    place: FloatArray  # (G, 2), in pixels of the small picture
    normal: FloatArray  # (G, 2)
    strength: FloatArray  # (G,), curvature in sigmas of its noise


def find_seeds(
    half: Picture,
    noise: PixelNoise,
    *,
    region: BoolArray | None,
    min_height: float,
    min_length_px: float,
) -> StripeSeeds:
    """Find places near bright ridges.

    Parameters
    ----------
    half
        Shape (H // 2, W // 2), the picture at half its size.
    noise
        Noise of the full picture's pixels.
    region
        Shape (H, W), where to look; None is everywhere.
    min_height
        Counts over the ground.
    min_length_px
        Shorter ridges are left out.
    """
    shrink = _SHRINK if 2 * max(half.shape) > _SMALL_SIDE_PX else _SHRINK_SMALL
    small = shrunk(half, 2) if shrink == _SHRINK else half
    deviation = np.sqrt(noise.floor) / shrink
    fine = _coarse_ridges(small, deviation, min_height)
    wide = _upscaled(_coarse_ridges(shrunk(small, 2), 0.5 * deviation, min_height))
    found = _joined(fine, _away_from(fine, wide, small.shape))
    if region is not None:
        pixel = np.rint(shrink * found.place + 0.5 * (shrink - 1)).astype(np.int64)
        pixel = np.clip(pixel, 0, np.array(region.shape)[::-1] - 1)
        found = _picked(found, region[pixel[:, 1], pixel[:, 0]])
    return _spread(_chained(found, min_length_px / shrink, _MOST_POINTS // shrink), shrink)


def _coarse_ridges(small: Picture, deviation: float, min_height: float) -> _CoarsePoints:
    """Return every pixel of the small picture on top of a line-like bright ridge."""
    smooth = np.asarray(cv2.sepFilter2D(small, cv2.CV_32F, _ROW, _ROW), dtype=np.float32)
    # Curvature per count at the top of a ridge half as wide as the kernel (Eq. 8), or twice.
    noise = _CURVATURE_NOISE * deviation
    least = max(0.12 * min_height / _KERNEL**2, _WEAK_SIGMAS * noise)
    place = np.flatnonzero(np.asarray(cv2.Laplacian(smooth, cv2.CV_32F)) < -0.8 * least)
    v, u = np.divmod(place, small.shape[1])
    pixel = np.column_stack([u, v])
    pixel = pixel[inside(small.shape, pixel, 1)]
    ridge = Ridge.from_derivatives(_differences(smooth, pixel))
    step_px = ridge.step_px()
    good = np.flatnonzero(
        (np.abs(step_px) <= _HALF_PIXEL).all(axis=1)
        & (-ridge.curvature > least)
        & (-ridge.along < _LINE_LIKE * -ridge.curvature)
        & (ridge.along < _DIP_LIKE * -ridge.curvature)
    )
    place_px = pixel[good] + step_px[good]
    return _CoarsePoints(place_px, ridge.normal[good], -ridge.curvature[good] / noise)


def _differences(smooth: Float32Array, pixel: IntArray) -> FloatArray:
    """Return g_u, g_v, g_uu, g_uv, g_vv at some pixels off the border, shape (N, 5).

    Differences of the smoothed picture do: the points found are but where to look.
    """
    pixels, width = smooth.reshape(-1), smooth.shape[1]
    here = pixel[:, 1] * width + pixel[:, 0]
    left, right, up, down = (pixels[here + by] for by in (-1, 1, -width, width))
    twice = 2.0 * pixels[here]
    rising = pixels[here + (width + 1)] + pixels[here - (width + 1)]
    falling = pixels[here + (width - 1)] + pixels[here - (width - 1)]
    parts = (
        0.5 * (right - left),
        0.5 * (down - up),
        left + right - twice,
        0.25 * (rising - falling),
        up + down - twice,
    )
    return np.stack(parts, axis=1).astype(np.float64)


def _upscaled(points: _CoarsePoints) -> _CoarsePoints:
    """Carry points of the smaller picture to the small one: one becomes two."""
    tangent = _pixel_steps(points.normal)
    place = 2.0 * points.place + 0.5
    return _CoarsePoints(
        np.concatenate([place - 0.5 * tangent, place + 0.5 * tangent]),
        np.tile(points.normal, (2, 1)),
        np.tile(points.strength, 2),
    )


def _pixel_steps(normal: FloatArray) -> FloatArray:
    """Return steps along a ridge that go on by one pixel in u or v, whichever is more."""
    tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
    longer = np.maximum(np.abs(normal[:, 0]), np.abs(normal[:, 1]))
    return np.asarray(tangent / longer[:, None])


def _joined(one: _CoarsePoints, other: _CoarsePoints) -> _CoarsePoints:
    return _CoarsePoints(
        np.concatenate([one.place, other.place]),
        np.concatenate([one.normal, other.normal]),
        np.concatenate([one.strength, other.strength]),
    )


def _picked(points: _CoarsePoints, keep: BoolArray | IntArray) -> _CoarsePoints:
    return _CoarsePoints(points.place[keep], points.normal[keep], points.strength[keep])


def _pixels(place: FloatArray, shape: tuple[int, ...]) -> IntArray:
    """Return the whole pixels (u, v) of places, kept inside the picture."""
    pixel = np.rint(place).astype(np.int64)
    return np.clip(pixel, 0, np.array(shape)[::-1] - 1)


def _away_from(fine: _CoarsePoints, wide: _CoarsePoints, shape: tuple[int, ...]) -> _CoarsePoints:
    """Keep the wide ridges that the fine kernel does not see: broad, clipped stripes."""
    near = cv2.dilate(_mask(fine, shape), np.ones((3, 3), dtype=np.uint8))
    pixel = _pixels(wide.place, shape)
    return _picked(wide, near[pixel[:, 1], pixel[:, 0]] == 0)


def _mask(points: _CoarsePoints, shape: tuple[int, ...]) -> NDArray[np.uint8]:
    mask = np.zeros(shape, dtype=np.uint8)
    pixel = _pixels(points.place, shape)
    mask[pixel[:, 1], pixel[:, 0]] = 1
    return mask


def _chained(points: _CoarsePoints, min_length: float, most: int) -> _CoarsePoints:
    """Keep the connected ridges that are long and strong enough, each sorted along itself."""
    chain, reach = _connected(points)
    strongest = np.zeros(len(reach))
    np.maximum.at(strongest, chain, points.strength)
    sound = (reach >= min_length) & (strongest >= _STRONG_SIGMAS)
    good = np.flatnonzero(sound[chain])
    if good.size > most:  # texture has tens of thousands
        good = good[np.argsort(-points.strength[good], kind="stable")[:most]]
    return _picked(points, good[order_along(points.place[good], chain[good])])


def _connected(points: _CoarsePoints) -> tuple[IntArray, IntArray]:
    """Return the number of each point's connected ridge, shape (N,), and how long each is, px."""
    if len(points.place) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    pixel = np.rint(points.place).astype(np.int64)
    # Only what holds ridges is searched.
    pixel -= pixel.min(axis=0) - 1
    mask = np.zeros(pixel.max(axis=0)[::-1] + 2, dtype=np.uint8)
    mask[pixel[:, 1], pixel[:, 0]] = 1
    # Speckle tears a ridge; a gap of one pixel is bridged.
    mask = cv2.dilate(mask, np.ones((3, 3), dtype=np.uint8))
    _, labels, boxes, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    reach = np.maximum(boxes[:, cv2.CC_STAT_WIDTH], boxes[:, cv2.CC_STAT_HEIGHT]) - 2
    return labels[pixel[:, 1], pixel[:, 0]].astype(np.int64), reach.astype(np.int64)


def _spread(points: _CoarsePoints, shrink: int) -> StripeSeeds:
    """Put seeds along each coarse ridge pixel, one per pixel of the full picture."""
    tangent = _pixel_steps(points.normal)
    along = np.arange(shrink) - 0.5 * (shrink - 1)
    centre = shrink * points.place + 0.5 * (shrink - 1)
    return StripeSeeds(
        centre[:, None, :] + along[None, :, None] * tangent[:, None, :], points.normal
    )
