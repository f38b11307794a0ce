"""Where a chessboard's inner corners may be: saddle points of brightness."""

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, Picture
from calib.seeing.noise import PixelNoise
from calib.seeing.resample import sampled, shrunk, smoothed, tops

_LARGEST_SIDE_PX = 1100
_KERNEL_PX = 2.0
_MOST_CORNERS = 2400
_RING_PX = 5.0
_RING_POINTS = 32
_ALIKE_ACROSS = 0.55


def find_corners(picture: Picture, noise: PixelNoise) -> FloatArray:
    """Find saddle points of brightness where two squares of a kind touch, to about a pixel.

    Returns
    -------
    place_px
        Shape (N, 2), the strongest first.
    """
    shrink = max(1, int(np.ceil(max(picture.shape) / _LARGEST_SIDE_PX)))
    small = shrunk(picture, shrink)
    smooth = smoothed(small.astype(np.float32), _KERNEL_PX)
    guu = cv2.Sobel(smooth, cv2.CV_32F, 2, 0, ksize=3, scale=0.25)
    gvv = cv2.Sobel(smooth, cv2.CV_32F, 0, 2, ksize=3, scale=0.25)
    guv = cv2.Sobel(smooth, cv2.CV_32F, 1, 1, ksize=3, scale=0.25)
    # At a corner of contrast 2 a the mixed derivative is 0.64 a / s².
    square = np.asarray(guv**2 - guu * gvv, dtype=np.float32)
    least = 0.3 * max(3.0, 3.0 * float(np.sqrt(noise.floor)) / shrink) / _KERNEL_PX**2
    v, u = np.nonzero(tops(square, 3) & (square > least**2))
    strongest = np.argsort(-square[v, u], kind="stable")[:_MOST_CORNERS]
    place = np.column_stack([u, v])[strongest].astype(np.float64)
    place = place[_looks_like_squares(small, place)]
    return np.asarray(shrink * place + 0.5 * (shrink - 1))


def _looks_like_squares(small: Picture, place: FloatArray) -> BoolArray:
    """Return where a ring about a place is alike on opposite sides, and half of it bright."""
    if len(place) == 0:
        return np.zeros(0, dtype=bool)
    angle = np.arange(_RING_POINTS) * (2.0 * np.pi / _RING_POINTS)
    u = place[:, :1] + _RING_PX * np.cos(angle)
    v = place[:, 1:] + _RING_PX * np.sin(angle)
    ring = sampled(small, u, v)
    ring -= ring.mean(axis=1, keepdims=True)
    power = np.maximum((ring**2).sum(axis=1), 1e-9)
    across = (ring * np.roll(ring, _RING_POINTS // 2, axis=1)).sum(axis=1) / power
    bright = (ring > 0.0).mean(axis=1)
    return np.asarray((across > _ALIKE_ACROSS) & (bright > 0.25) & (bright < 0.75))
