"""The array types of the mathematics, and how a value keeps its arrays from being changed."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Picture = NDArray[np.uint8]


def frozen(values: ArrayLike, shape: Sequence[int | None], name: str) -> FloatArray:
    """Return a read-only float64 copy of `values` after checking its shape.

    Parameters
    ----------
    values
        Anything NumPy turns into numbers.
    shape
        Expected shape; ``None`` stands for any length.
    name
        What the values are, for the message.

    Raises
    ------
    ValueError
        If the shape differs or an entry is not finite.
    """
    array = np.array(values, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ValueError(f"{name} must have shape {tuple(shape)}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array[~np.isfinite(array)][0]}")
    array.setflags(write=False)
    return array


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only copy of `array`, its type kept."""
    copy = array.copy()
    copy.setflags(write=False)
    return copy
