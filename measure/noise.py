"""How the points of a stripe scatter about a smooth profile: speckle, and what neighbours share."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from calib import BoolArray, FloatArray

_GAP_MM = 2.0
_MEDIAN_POINTS = 9
# Long enough to see what neighbours share, short enough that wear is smooth over it: 17 mm.
_LONG_POINTS = 61
_MAX_LAG = 30
_CLIP_SIGMAS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Scatter of the points across the profile.

    Attributes
    ----------
    speckle_share
        Part of the stripe's width by which points scatter beyond what their sigmas say. Speckle
        moves the centre of a stripe by a share of its width, however bright it is.
    run_points
        How many neighbours are off together, and count as one in a mean.
    sigma_mm
        Shape (N,): standard deviation of each point, speckle and all.
    """

    speckle_share: float
    run_points: float
    sigma_mm: FloatArray

    @property
    def counting_mm(self) -> FloatArray:
        """Shape (N,): what to give each point in a mean that takes points for independent."""
        return np.asarray(self.sigma_mm * np.sqrt(self.run_points))


def noise_of(
    along_mm: FloatArray,
    outside_mm: FloatArray,
    sigma_mm: FloatArray,
    width_mm: FloatArray,
    smooth: BoolArray,
) -> Noise:
    """Estimate the scatter of ordered points from the points themselves.

    Parameters
    ----------
    along_mm, outside_mm
        Shape (N,): place along the reference and height over it.
    sigma_mm
        Shape (N,): what the pixels' noise makes.
    width_mm
        Shape (N,): the stripe's width as it shows across the profile.
    smooth
        Shape (N,): where wear makes no features of its own; only there scatter can be told
        from wear.

    Returns
    -------
    Noise
        Never less than `sigma_mm`.
    """
    rest = rest_of(along_mm[smooth], outside_mm[smooth], _LONG_POINTS)
    width, own = width_mm[smooth], sigma_mm[smooth]
    excess = robust_sigma(rest / width) ** 2 - _median_square(own / width)
    share = float(np.sqrt(max(excess, 0.0)))
    sigma = np.hypot(sigma_mm, share * width_mm)
    score = np.clip(rest / sigma[smooth], -_CLIP_SIGMAS, _CLIP_SIGMAS)
    return Noise(share, _run_points(score), sigma)


def rest_of(along_mm: FloatArray, outside_mm: FloatArray, points: int) -> FloatArray:
    """Return how far each point lies off a running parabola through `points` neighbours, mm.

    Runs too short for it are left at zero; gross errors do not bend the parabola.
    """
    rest = np.zeros(len(along_mm))
    breaks = np.flatnonzero(np.diff(along_mm) > _GAP_MM) + 1
    for run in np.split(np.arange(len(along_mm)), breaks):
        if len(run) < points:
            continue
        height = outside_mm[run]
        rough = height - median_filter(height, _MEDIAN_POINTS, mode="nearest")
        gross = np.abs(rough) > 6.0 * max(robust_sigma(rough), 1e-6)
        steady = np.where(gross, height - rough, height)
        rest[run] = height - savgol_filter(steady, points, 2)
    # The point itself takes part in its parabola: 9 / 4K of its variance is hidden there.
    return np.asarray(rest / np.sqrt(1.0 - 9.0 / (4.0 * points)))


def robust_sigma(values: FloatArray) -> float:
    """Return the standard deviation that the median deviation from zero stands for."""
    return float(1.4826 * np.median(np.abs(values))) if len(values) else 0.0


def _median_square(values: FloatArray) -> float:
    return float(np.median(np.square(values))) if len(values) else 0.0


def _run_points(score: FloatArray) -> float:
    """Return 1 + 2 (sum of the correlations of neighbours), as far as they are there."""
    power = float(np.mean(score**2)) if len(score) > 4 * _MAX_LAG else 0.0
    if not power > 0.0:
        return 1.0
    length = 1.0
    # A parabola through K points leaves the residuals of white noise a correlation of -9 / 4K.
    expected = -9.0 / (4.0 * _LONG_POINTS)
    for lag in range(1, _MAX_LAG + 1):
        correlation = float(np.mean(score[lag:] * score[:-lag])) / power - expected
        if correlation < 3.0 / np.sqrt(len(score)):
            break
        length += 2.0 * correlation
    return length
