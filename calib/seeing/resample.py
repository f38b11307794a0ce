"""Pictures made smaller, smoother, or read between their pixels.

OpenCV does the work; bytes stay bytes and floats floats. Beyond the border the nearest pixel
repeats.
"""

from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from calib.arrays import FloatArray, Picture

Float32Array = NDArray[np.float32]
Pixels = TypeVar("Pixels", Picture, Float32Array)

_REPEAT = cv2.BORDER_REPLICATE


def shrunk(picture: Pixels, times: int) -> Pixels:
    """Return a picture whose pixels are means of `times` x `times`; what is over is lost.

    Place p of the result is place ``times * p + (times - 1) / 2`` of the picture.
    """
    height, width = (max(side // times, 1) for side in picture.shape)
    cut = picture[: times * height, : times * width]
    return _like(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA), picture)


def smoothed(picture: Pixels, sigma_px: float) -> Pixels:
    """Return a picture convolved with a Gaussian."""
    return _like(cv2.GaussianBlur(picture, (0, 0), sigma_px, borderType=_REPEAT), picture)


def box_smoothed(picture: Picture) -> Picture:
    """Return a picture of means of three by three pixels."""
    return _like(cv2.blur(picture, (3, 3), borderType=_REPEAT), picture)


def tops(response: Float32Array, reach: int) -> NDArray[np.bool_]:
    """Return which pixels none within `reach` exceeds."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    return np.asarray(response == cv2.dilate(response, square))


def sampled(picture: Picture, u: FloatArray, v: FloatArray) -> Float32Array:
    """Return brightness between pixels, bilinear, of the shape of `u` and `v`.

    The first two axes, the others put together, must each be shorter than 32767.
    """
    if u.size == 0:
        return np.zeros(u.shape, dtype=np.float32)
    flat_u, flat_v = (x.reshape(len(x), -1).astype(np.float32) for x in (u, v))
    values = cv2.remap(picture, flat_u, flat_v, cv2.INTER_LINEAR, borderMode=_REPEAT)
    return np.asarray(values, dtype=np.float32).reshape(u.shape)


def _like(made: NDArray[np.generic], picture: Pixels) -> Pixels:
    return np.asarray(made, dtype=picture.dtype)
