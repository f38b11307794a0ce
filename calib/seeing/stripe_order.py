"""Points along a stripe: their order, and means over neighbours."""

import numpy as np

from calib.arrays import FloatArray, IntArray


def order_along(place_px: FloatArray, chain: IntArray) -> IntArray:
    """Return the index that sorts points by chain, and along the longer side of each."""
    if len(place_px) == 0:
        return np.zeros(0, dtype=np.int64)
    count = int(chain.max()) + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, chain, place_px)
    np.maximum.at(high, chain, place_px)
    upright = (high - low)[:, 1] > (high - low)[:, 0]
    along = np.where(upright[chain], place_px[:, 1], place_px[:, 0])
    return np.lexsort((along, chain))


def running_mean(
    values: FloatArray, place_px: FloatArray, *, half_window: int, gap_px: float
) -> FloatArray:
    """Average sorted `values`, shape (N, D), over neighbours that follow without a gap.

    Near a gap the window shrinks on both sides alike, so that a trend is kept.
    """
    count = len(values)
    if count == 0:
        return values
    jump = np.abs(np.diff(place_px, axis=0)).max(axis=1) > gap_px
    segment = np.concatenate([[0], np.cumsum(jump)])
    first = np.flatnonzero(np.concatenate([[True], jump]))
    last = np.concatenate([first[1:], [count]]) - 1
    index = np.arange(count)
    room = np.minimum(index - first[segment], last[segment] - index)
    half = np.minimum(room, half_window)
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    width = (2 * half + 1)[:, None]
    return np.asarray((total[index + half + 1] - total[index - half]) / width)
