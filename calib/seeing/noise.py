"""The noise of a picture's pixels, told from the picture itself."""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from calib.arrays import FloatArray, Picture

Int16Array = NDArray[np.int16]
UInt16Array = NDArray[np.uint16]

SATURATED_FROM = 250
"""Counts from which a pixel is taken as clipped: below 255, for resampling mixes neighbours."""

_PIXELS = 1 << 16  # looked at, in whole rows
_MORE_BRIGHT = 1 << 14  # at most, from rows between: a stripe alone shows too few
_BRIGHT_FROM = 24  # well below the second bin
_LARGEST_MASK = 511
_LEVEL_WIDTH = 4
_LEVELS = 256 // _LEVEL_WIDTH
_BINS = 8  # each of some levels
_FEWEST_IN_BIN = 125
_MASK_NORM = 6.0  # root of the summed squares of [1, -2, 1] x [1, -2, 1]
_MEDIAN_OF_HALF_NORMAL = 0.6745
_QUANTISATION = 1.0 / 12.0

_USED = slice(2, SATURATED_FROM - 10)  # black and clipped pixels show less noise
_LEVEL_OF = np.full(256, _LEVELS)  # those left out have a level of their own
_LEVEL_OF[_USED] = np.arange(256)[_USED] // _LEVEL_WIDTH
_LEVEL_START = (_LEVEL_OF * (_LARGEST_MASK + 1)).astype(np.uint16)
_BRIGHTNESS = (np.arange(_LEVELS) + 0.5) * _LEVEL_WIDTH - 0.5


@dataclass(frozen=True, slots=True)
class PixelNoise:
    """Variance of a pixel's noise: ``floor + gain * brightness``.

    Attributes
    ----------
    floor
        Read noise and quantisation, counts squared.
    gain
        Shot noise, counts squared per count.

    Raises
    ------
    ValueError
        If the floor is not positive or the gain is negative.
    """

    floor: float
    gain: float = 0.0

    def __post_init__(self) -> None:
        if not (self.floor > 0.0 and self.gain >= 0.0):
            raise ValueError(
                f"noise floor must be positive and gain not negative, got {self.floor}, {self.gain}"
            )

    def variance(self, brightness: FloatArray) -> FloatArray:
        """Return the variance, counts squared, at each brightness; any shape."""
        return self.floor + self.gain * np.clip(brightness, 0.0, 255.0)

    @classmethod
    def from_picture(cls, picture: Picture) -> Self:
        r"""Estimate the noise of a picture that shows things as well.

        Parameters
        ----------
        picture
            Shape (H, W), 8 bit.

        Returns
        -------
        PixelNoise
            A picture too small or too clipped to tell from gets the noise of quantisation.

        Notes
        -----
        The mask ``[1, -2, 1]`` along both axes [1]_ leaves little but noise. The median of its
        size, in classes of brightness, gives a variance per class, and a line through them the
        floor and the gain. Structure only ever adds, so classes far above the line are let go.
        Clipped and black pixels are left out. Of a large picture some rows are looked at.

        References
        ----------
        .. [1] J. Immerkaer, "Fast noise variance estimation", Computer Vision and Image
           Understanding 64(2), 1996.
        """
        brightness, variance, count = _variance_by_brightness(picture)
        if brightness.size == 0:
            return cls(_QUANTISATION)
        floor, gain = _lower_line(brightness, variance, count)
        return cls(max(floor, _QUANTISATION), max(gain, 0.0))


def _variance_by_brightness(picture: Picture) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return brightness, variance and number of pixels of each class that has enough."""
    if min(picture.shape) < 3:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    step = max(round(picture.size / _PIXELS), 1)
    more = _placed(*_bright_between(picture, step))
    # The first bin, the dark, has enough, and of it these are but the brightest.
    more = more[more >= _LEVELS // _BINS * (_LARGEST_MASK + 1)]
    place = np.concatenate([_placed(*_rows(picture, step)), more])
    counted = np.bincount(place, minlength=(_LEVELS + 1) * (_LARGEST_MASK + 1))
    by_level = counted.reshape(_LEVELS + 1, _LARGEST_MASK + 1)[:_LEVELS]
    masks = by_level.reshape(_BINS, -1, _LARGEST_MASK + 1).sum(axis=1)
    total = (by_level.sum(axis=1) * _BRIGHTNESS).reshape(_BINS, -1).sum(axis=1)
    count = masks.sum(axis=1)
    enough = np.flatnonzero(count >= _FEWEST_IN_BIN)
    median = np.array([_median_of_counts(masks[i]) for i in enough])
    sigma = median / (_MEDIAN_OF_HALF_NORMAL * _MASK_NORM)
    return total[enough] / count[enough], sigma**2, count[enough].astype(np.float64)


def _rows(picture: Picture, step: int) -> list[Int16Array]:
    """Return every so manyeth row, and those above and below them."""
    last = picture.shape[0] - 2
    return [picture[down : last + down : step].astype(np.int16) for down in range(3)]


def _bright_between(picture: Picture, step: int) -> list[Int16Array]:
    """Return three columns about bright pixels of the rows between, and the same above and below.

    Where all is dark but for a stripe, one pixel in a thousand tells what brightness adds.
    """
    apart = max(step // 4, 1)
    first = 1 + apart // 2
    bright = np.flatnonzero(picture[first:-1:apart, :-2] >= _BRIGHT_FROM)
    v, u = np.divmod(bright[:: max(-(-bright.size // _MORE_BRIGHT), 1)], picture.shape[1] - 2)
    v, u = apart * v[:, None] + first, u[:, None] + np.arange(3)
    return [picture[v + down, u].astype(np.int16) for down in (-1, 0, 1)]


def _placed(top: Int16Array, middle: Int16Array, bottom: Int16Array) -> UInt16Array:
    """Return level and size of the mask of each pixel, as one number."""
    if middle.size == 0:
        return np.zeros(0, dtype=np.uint16)
    bend = top - 2 * middle + bottom
    mask = np.abs(bend[:, :-2] - 2 * bend[:, 1:-1] + bend[:, 2:])
    level = (middle[:, :-2] + 2 * middle[:, 1:-1] + middle[:, 2:]) >> 2
    start = np.asarray(cv2.LUT(level.astype(np.uint8), _LEVEL_START))
    return np.asarray(start + np.minimum(mask, _LARGEST_MASK).astype(np.uint16)).ravel()


def _median_of_counts(histogram: FloatArray) -> float:
    """Return the median of whole numbers, told to a fraction within its class.

    The numbers are sizes: class 0 stands for [0, 0.5), class k for [k - 0.5, k + 0.5).
    """
    cumulated = np.cumsum(histogram)
    half = 0.5 * float(cumulated[-1])
    k = int(np.searchsorted(cumulated, half))
    below = float(cumulated[k - 1]) if k > 0 else 0.0
    share = (half - below) / float(histogram[k])
    return 0.5 * share if k == 0 else k - 0.5 + share


def _lower_line(
    brightness: FloatArray, variance: FloatArray, count: FloatArray
) -> tuple[float, float]:
    """Fit ``variance = floor + gain * brightness`` from below: structure only ever adds."""
    design = np.column_stack([np.ones(brightness.size), brightness])
    # A variance's own error is a share of it.
    weight = np.sqrt(np.minimum(count, 20000.0)) / np.maximum(variance, 0.05)
    keep = np.ones(brightness.size, dtype=bool)
    while keep.sum() > 1:
        (floor, gain), _ = nnls(design[keep] * weight[keep, None], (variance * weight)[keep])
        below = keep & (variance <= 1.5 * (floor + gain * brightness) + 0.05)
        if (below == keep).all():
            return float(floor), float(gain)
        keep = below
    return float(variance[keep][0]) if keep.any() else float(variance.min()), 0.0
