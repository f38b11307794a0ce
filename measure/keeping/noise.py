"""How the points of a stripe scatter about a smooth profile: speckle, and what neighbours share."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import median_filter

from calib import BoolArray, FloatArray

_GAP_MM = 2.0
_MEDIAN_POINTS = 9
# Long enough to see what neighbours share, short enough that wear is smooth over it: 12 mm.
_LONG_POINTS = 45
_LAGS = np.arange(1, 5)
# The spread over which neighbours share their errors, in points, that is looked for.
_SPREADS = np.linspace(0.3, 8.0, 78)  # of 0.3 nothing is shared
_FEWEST_POINTS = 120
_CHANCE_SIGMAS = 3.0
_CLIP_SIGMAS = 3.0
_ROUNDS = 3
_MOST_HIDDEN = 0.5


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
    run_points = 1.0
    for _ in range(_ROUNDS):
        # The parabola follows what neighbours share: the longer their runs, the more it hides.
        hidden = min(_hidden(_LONG_POINTS, run_points), _MOST_HIDDEN)
        shown = rest / np.sqrt(1.0 - hidden)
        excess = robust_sigma(shown / width) ** 2 - _median_square(own / width)
        share = float(np.sqrt(max(excess, 0.0)))
        score = shown / np.hypot(own, share * width)
        run_points = _run_points(np.clip(score, -_CLIP_SIGMAS, _CLIP_SIGMAS), hidden)
    return Noise(share, run_points, np.hypot(sigma_mm, share * width_mm))


def rest_of(along_mm: FloatArray, outside_mm: FloatArray, points: int) -> FloatArray:
    """Return how far each point lies off a running parabola through `points` neighbours, mm.

    Runs too short for it are left at zero; gross errors do not bend the parabola. A part of the
    points' own scatter is hidden in it: 9 / 4K of the variance of white noise.
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
        rest[run] = height - _running_parabola(steady, points)
    return rest


def _running_parabola(values: FloatArray, points: int) -> FloatArray:
    """Return the middle of a parabola through `points` neighbours, an odd number, at each place.

    At both ends it is the first and the last parabola itself.
    """
    hat = _hat_of_parabola(points)
    half = points // 2
    inner = np.convolve(values, hat[half], mode="valid")  # the middle row reads the same backwards
    ends = hat[:half] @ values[:points], hat[half + 1 :] @ values[-points:]
    return np.concatenate([ends[0], inner, ends[1]])


@lru_cache(maxsize=4)
def _hat_of_parabola(points: int) -> FloatArray:
    """Return what takes values to those of the parabola through them, (points, points)."""
    design = np.vander(np.linspace(-1.0, 1.0, points), 3)
    return np.asarray(design @ np.linalg.pinv(design))


def robust_sigma(values: FloatArray) -> float:
    """Return the standard deviation that the median deviation from zero stands for."""
    return float(1.4826 * np.median(np.abs(values))) if len(values) else 0.0


def _median_square(values: FloatArray) -> float:
    return float(np.median(np.square(values))) if len(values) else 0.0


def _hidden(points: int, run_points: float) -> float:
    """Return the share of the variance that a parabola through so many points follows."""
    return 9.0 * run_points / (4.0 * points)


def _run_points(score: FloatArray, hidden: float) -> float:
    r"""Return 1 + 2 (sum of the correlations of neighbours).

    The kernel that locates a stripe and the optics that blur its speckle are both bells: errors
    r points apart are correlated by :math:`\exp(-r^2 / 4 s^2)`. The spread s is told by the nearest
    neighbours; adding up the correlations found out to where they vanish would add up their noise.
    """
    power = float(np.mean(score**2)) if len(score) >= _FEWEST_POINTS else 0.0
    if not power > 0.0:
        return 1.0
    seen = np.array([np.mean(score[lag:] * score[:-lag]) for lag in _LAGS]) / power
    # What the parabola took is missing from all correlations alike.
    together = float(np.sum(seen * (1.0 - hidden) + hidden))
    if not together > _CHANCE_SIGMAS * np.sqrt(len(_LAGS) / len(score)):
        return 1.0
    expected = np.exp(-((_LAGS / _SPREADS[:, None]) ** 2) / 4.0).sum(axis=1)
    spread = float(np.interp(together, expected, _SPREADS))
    return 2.0 * float(np.sqrt(np.pi)) * spread
