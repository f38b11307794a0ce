"""The centres of a chessboard's inner corners, and how well they are known."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing import saddle
from calib.seeing.coherence import in_squares
from calib.seeing.lattice import Lattice
from calib.seeing.noise import PixelNoise
from calib.seeing.patch_fit import Effort, PatchFit, fit_patches
from calib.seeing.patch_spread import LARGEST_SCALE_PX, sigma_with_spread, spread_over_scales
from calib.seeing.patches import Patches
from calib.seeing.resample import box_smoothed
from calib.seeing.stripe_lines import StripeLine, lit_by
from calib.views import Cause

_PATCH_PITCHES, _LARGEST_PATCH_PX, _SMALLEST_PATCH_PX = 0.38, 11.0, 3.5
_START_BLUR_PX = 1.2
_EFFORT = Effort(tolerance_px=5e-4, most_steps=12)
_STRIPE_FOOT = 0.06  # of half a corner's contrast
_CROSSED_FROM, _CLIPPED_FROM, _MOST_HIDDEN = 0.02, 0.05, 0.6
_FAINTEST, _LEAST_HEIGHT = 0.2, 2.0
_FARTHEST_PITCHES = 0.2
_LARGEST_SIGMA_PX = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """What was measured of N corners: centre and sigma, (N, 2), what is doubtful, what to trust."""

    centre_px: FloatArray
    sigma_px: FloatArray
    cause: tuple[Cause, ...]
    trusted: BoolArray


def measure_corners(
    picture: Picture,
    noise: PixelNoise,
    lattice: Lattice,
    node: IntArray,
    lines: list[StripeLine],
) -> Corners:
    """Fit the picture of a corner at each node of a lattice.

    Sigma is the larger of the fit's, and of half the spread of the centre over Gaussian
    kernels. Pixels that a stripe lights up are not looked at.

    Parameters
    ----------
    picture
        Shape (H, W).
    noise
        Noise of its pixels.
    lattice
        The corners' lattice: it tells where edges run.
    node
        Shape (N, 2), which nodes.
    lines
        Stripes across the board.
    """
    centre = lattice.predict(node)
    edges = np.stack(
        [lattice.predict(node + np.array(step)) - centre for step in ((0, 1), (1, 0))], axis=1
    )
    pitch = float(np.median(np.linalg.norm(edges, axis=2).min(axis=1)))
    patches = _cut(picture, noise, centre, pitch)
    contrast = 0.5 * np.ptp(np.percentile(patches.samples, [15, 85], axis=1), axis=0)
    place, foot = patches.places_px(), _STRIPE_FOOT * contrast
    band = lit_by(lines, place, foot)
    first = saddle.start(centre, patches.origin.astype(np.float64), edges, _START_BLUR_PX)
    fit = fit_patches(patches.without(band), first, saddle.evaluate, saddle.sound, effort=_EFFORT)
    seen = patches.without(lit_by(lines, place, foot, LARGEST_SCALE_PX))
    spread = spread_over_scales(picture, seen, fit, saddle.evaluate, saddle.BLUR)
    sigma = sigma_with_spread(fit.sigma_px, spread)
    hidden = band.mean(axis=1)
    return Corners(
        centre_px=fit.parameters[:, :2] + patches.origin,
        sigma_px=sigma,
        cause=_causes(hidden, patches.clipped.mean(axis=1)),
        trusted=_trusted(fit, first, sigma, pitch) & (hidden < _MOST_HIDDEN),
    )


def _cut(picture: Picture, noise: PixelNoise, centre: FloatArray, pitch: float) -> Patches:
    """Cut a round window about each corner, well inside the four squares."""
    reach = float(np.clip(_PATCH_PITCHES * pitch, _SMALLEST_PATCH_PX, _LARGEST_PATCH_PX))
    side = np.arange(-int(reach), int(reach) + 1)
    offset = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    offset = in_squares(offset[np.hypot(*offset.T) <= reach])
    use = np.ones((len(centre), len(offset)), dtype=bool)
    origin = np.rint(centre).astype(np.int64)
    return Patches.cut(picture, box_smoothed(picture), noise, origin, offset, use)


def _trusted(fit: PatchFit, first: FloatArray, sigma: FloatArray, pitch: float) -> BoolArray:
    height = np.abs(fit.parameters[:, saddle.HEIGHT])
    moved = np.linalg.norm(fit.parameters[:, :2] - first[:, :2], axis=1)
    return np.asarray(
        (moved < _FARTHEST_PITCHES * pitch)
        & (height > np.maximum(_FAINTEST * np.median(height), _LEAST_HEIGHT))
        & (sigma.max(axis=1) < _LARGEST_SIGMA_PX)
    )


def _causes(hidden: FloatArray, clipped: FloatArray) -> tuple[Cause, ...]:
    """Say what is doubtful about each corner."""
    crossed, saturated = hidden > _CROSSED_FROM, clipped > _CLIPPED_FROM
    return tuple(
        Cause.CROSSED if c else Cause.SATURATED if s else Cause.NONE
        for c, s in zip(crossed, saturated, strict=True)
    )
