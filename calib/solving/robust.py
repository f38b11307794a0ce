"""How far true values scatter, where up to a half of all are false."""

import numpy as np

from calib.arrays import FloatArray

# Median of the absolute value of a standard normal variable.
_MEDIAN_OF_NORMAL = 0.6745


def robust_limit(misses: FloatArray, sigmas: float) -> float:
    """Return so many standard deviations of misses, shape (N,), as their median tells them."""
    return float(sigmas * np.median(misses) / _MEDIAN_OF_NORMAL)
