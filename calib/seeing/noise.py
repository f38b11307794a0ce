"""The noise of a picture's pixels, told from the picture itself."""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from calib.arrays import FloatArray, Picture

Int16Array = NDArray[np.int16]

SATURATED_FROM = 250
"""Counts from which a pixel is taken as clipped: below 255, for resampling mixes neighbours."""

_ROW_STEP = 16
_BLOCK_ROWS = 256  # looked at together: few enough to stay in the processor's cache
_LARGEST_MASK = 511
_BIN_WIDTH = 32
_BINS = 256 // _BIN_WIDTH
_FEWEST_IN_BIN = 125
_MASK_NORM = 6.0  # root of the summed squares of [1, -2, 1] x [1, -2, 1]
_MEDIAN_OF_HALF_NORMAL = 0.6745
_QUANTISATION = 1.0 / 12.0

_LEFT_OUT = np.r_[0:2, SATURATED_FROM - 10 : 256]  # black and clipped pixels show less noise
_BIN_START = (np.arange(256) // _BIN_WIDTH * (_LARGEST_MASK + 1)).astype(np.int16)
_BIN_START[_LEFT_OUT] = _BINS * (_LARGEST_MASK + 1)  # a bin of their own


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
        Clipped and black pixels are left out. Every sixteenth row is looked at.

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
    pixels = np.zeros(256)
    masks = np.zeros((_BINS, _LARGEST_MASK + 1), dtype=np.int64)
    last = picture.shape[0] - 2
    for first in range(0, last if picture.shape[1] >= 3 else 0, _BLOCK_ROWS):
        level, mask = _levels_and_masks(picture, first, min(first + _BLOCK_ROWS, last))
        pixels += cv2.calcHist([level], [0], None, [256], [0, 256]).ravel()
        place = np.asarray(cv2.LUT(level, _BIN_START)) + mask
        binned = np.bincount(place.ravel(), minlength=masks.size)
        masks += binned[: masks.size].reshape(masks.shape)
    pixels[_LEFT_OUT] = 0
    count = masks.sum(axis=1)
    enough = np.flatnonzero(count >= _FEWEST_IN_BIN)
    total = (pixels * np.arange(256)).reshape(_BINS, _BIN_WIDTH).sum(axis=1)
    brightness = total[enough] / count[enough]
    median = np.array([_median_of_counts(masks[i]) for i in enough])
    sigma = median / (_MEDIAN_OF_HALF_NORMAL * _MASK_NORM)
    return brightness, sigma**2, count[enough].astype(np.float64)


def _levels_and_masks(picture: Picture, first: int, end: int) -> tuple[Picture, Int16Array]:
    """Return brightness and the mask's size at pixels of every sixteenth row of some."""
    top, middle, bottom = (
        picture[first + down : end + down : _ROW_STEP].astype(np.int16) for down in range(3)
    )
    bend = top - 2 * middle + bottom
    mask = np.minimum(np.abs(bend[:, :-2] - 2 * bend[:, 1:-1] + bend[:, 2:]), _LARGEST_MASK)
    level = (middle[:, :-2] + 2 * middle[:, 1:-1] + middle[:, 2:]) >> 2
    return level.astype(np.uint8), mask


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
    keep = np.ones(brightness.size, dtype=bool)
    floor, gain = float(variance.min()), 0.0
    for _ in range(4):
        # A variance's own error is a share of it, so weigh by 1 / variance.
        weight = np.sqrt(np.minimum(count[keep], 20000.0)) / np.maximum(variance[keep], 0.05)
        if keep.sum() >= 2:
            design = np.column_stack([np.ones(keep.sum()), brightness[keep]])
            solution = np.linalg.lstsq(design * weight[:, None], variance[keep] * weight)[0]
            floor, gain = float(solution[0]), float(solution[1])
        if keep.sum() < 2 or gain < 0.0 or floor < 0.0:
            gain = max(gain, 0.0) if floor > 0.0 else float(np.median(variance / brightness))
            floor = float(np.average(variance[keep], weights=weight)) if gain == 0.0 else 0.0
        now = variance <= 1.5 * (floor + gain * brightness) + 0.05
        if (now == keep).all() or not now.any():
            break
        keep = now
    return floor, gain
