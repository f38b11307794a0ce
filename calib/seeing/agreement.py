"""Which points agree with all others that they belong to one flat target."""

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.homography import apply_homography

_FEWEST_POINTS = 6
_FARTHEST_OFF_PX = 8.0
_NEAREST_OFF_PX = 0.05
_FAR_OFF_PX = 0.3
_FAR_OFF_SIGMAS = 5.0


def agreeing(
    place: IntArray, centre_px: FloatArray, sigma_px: FloatArray
) -> tuple[FloatArray, BoolArray] | None:
    """Fit the map from (row, col) to the picture, and tell which points agree with it.

    Parameters
    ----------
    place
        Shape (N, 2), (row, col).
    centre_px, sigma_px
        Shape (N, 2).

    Returns
    -------
    None
        Where fewer than six points, or points on one line, agree on anything.
    homography
        Shape (3, 3).
    agree
        Shape (N,). A lens bends a target by up to some pixels: smoothly, as a polynomial of the
        third degree follows. What is off by more than that, by its own sigma and by what is
        usual in the picture, is no point of the target, or one that light has displaced.
    """
    if len(place) < _FEWEST_POINTS:
        return None
    found, near = cv2.findHomography(
        place.astype(np.float64), centre_px, cv2.RANSAC, _FARTHEST_OFF_PX
    )
    if found is None or near.sum() < _FEWEST_POINTS:
        return None
    homography = np.asarray(found, dtype=np.float64)
    agree: BoolArray = np.asarray(near.ravel() > 0)
    off = centre_px - apply_homography(homography, place.astype(np.float64))
    x, y = ((place - place.mean(axis=0)) / max(float(np.ptp(place)), 1.0)).T
    bend = np.stack([x**i * y**j for i in range(4) for j in range(4 - i)], axis=1)
    weight = agree / np.maximum(sigma_px.max(axis=1), _NEAREST_OFF_PX)
    for _ in range(6):
        shape = np.linalg.lstsq(bend * weight[:, None], off * weight[:, None])[0]
        rest = np.linalg.norm(off - bend @ shape, axis=1)
        limit = np.maximum(_NEAREST_OFF_PX, 3.0 * sigma_px.max(axis=1))
        weight = agree / limit / (1.0 + (rest / limit) ** 2)
    usual = float(np.median(rest[agree])) / 1.1774  # the median of two normal parts, as a sigma
    limit = np.maximum(_FAR_OFF_PX, _FAR_OFF_SIGMAS * np.maximum(sigma_px.max(axis=1), usual))
    return homography, agree & (rest <= limit)
