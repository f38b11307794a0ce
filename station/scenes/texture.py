"""Random fields: metal, ground, shine, speckle.  All have mean 0 and standard deviation 1."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from station.scenes.patch import Counts


def clouds(rng: np.random.Generator, shape: tuple[int, int], coarsest_px: float) -> Counts:
    """Return a smooth field with detail at every size from `coarsest_px` down to 4 px.

    Each octave has 0.6 of the strength of the one twice its size.
    """
    rows, columns = shape
    field = np.zeros(shape, dtype=np.float32)
    size, strength = coarsest_px, 1.0
    while size >= 4.0:
        cells = (max(2, math.ceil(rows / size) + 1), max(2, math.ceil(columns / size) + 1))
        octave = rng.standard_normal(cells, dtype=np.float32)
        field += strength * cv2.resize(octave, (columns, rows), interpolation=cv2.INTER_CUBIC)
        size, strength = size / 2.0, strength * 0.6
    return _normalised(field)


def brushed(rng: np.random.Generator, shape: tuple[int, int]) -> Counts:
    """Return the grain of a brushed plate: long along the columns' axis, fine across."""
    white = rng.standard_normal(shape, dtype=np.float32)
    fine = cv2.GaussianBlur(white, (0, 0), sigmaX=12.0, sigmaY=0.8)
    return _normalised(_normalised(np.asarray(fine)) + np.float32(0.7) * clouds(rng, shape, 64.0))


def speckle(
    rng: np.random.Generator, shape: tuple[int, int], contrast: float, grain_px: float = 0.8
) -> Counts:
    """Return the factor by which speckle changes a stripe of laser light, mean 1.

    Parameters
    ----------
    rng
        Draws the grains.
    shape
        Rows and columns.
    contrast
        Standard deviation over mean, after the averaging of lens and pixel.
    grain_px
        Standard deviation of a grain: the point spread of the optics.

    Notes
    -----
    Averaged over the few grains a pixel gathers, the intensity follows a gamma law; at the
    contrasts of 0.05-0.15 seen through a rough surface a normal law clipped at zero differs
    from it by less than the shot noise.
    """
    if contrast == 0.0:
        return np.ones(shape, dtype=np.float32)
    white = rng.standard_normal(shape, dtype=np.float32)
    # White noise through a Gaussian of sigma g keeps the standard deviation 1 / (2 sqrt(pi) g).
    strength = np.float32(contrast * 2.0 * math.sqrt(math.pi) * grain_px)
    grains = strength * cv2.GaussianBlur(white, (0, 0), grain_px)
    return np.asarray(np.maximum(1.0 + grains, 0.0), dtype=np.float32)


def _normalised(field: NDArray[np.floating]) -> Counts:
    return np.asarray((field - field.mean()) / field.std(), dtype=np.float32)
