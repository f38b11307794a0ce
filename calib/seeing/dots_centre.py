"""The centres of dots whose outlines are roughly known, and how well they are known."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing import disc
from calib.seeing.ellipse import Ellipses
from calib.seeing.noise import PixelNoise
from calib.seeing.patch_fit import (
    SCALES_PX,
    Patches,
    PatchFit,
    fit_patches,
    masked_median,
    spread_over_scales,
)
from calib.seeing.resample import box_smoothed
from calib.seeing.stripe_lines import StripeLine, lit_by

_EDGE_REACH_PX = 4.5
_START_BLUR_PX = 1.5
_LARGEST_SIGMA = 0.15  # of the radius: beyond, it is not sure that this is a dot
_STRIPE_FOOT = 0.04  # of a dot's height: what of a stripe does not disturb its edge


@dataclass(frozen=True, slots=True, eq=False)
class DotCentres:
    """What was measured of N dots.

    Attributes
    ----------
    centre_px, sigma_px
        Shape (N, 2).
    outlines
        The N ellipses.
    height, ground, slope
        Shape (N,): counts over the ground as seen, counts of the ground, change of the ground
        across the dot.
    scatter
        Shape (N,), what the fit leaves over what noise explains.
    hidden, clipped
        Shape (N,), share of the edge under a stripe, share of the pixels at the sensor's limit.
    trusted
        Shape (N,), the fit found a disc of the size looked for, where it was looked for.
    """

    centre_px: FloatArray
    sigma_px: FloatArray
    outlines: Ellipses
    height: FloatArray
    ground: FloatArray
    slope: FloatArray
    scatter: FloatArray
    hidden: FloatArray
    clipped: FloatArray
    trusted: BoolArray

    def __len__(self) -> int:
        return len(self.centre_px)


def measure_dots(
    picture: Picture,
    noise: PixelNoise,
    outlines: Ellipses,
    lines: list[StripeLine],
    *,
    dark: bool,
) -> DotCentres:
    r"""Fit a blurred, clipped disc to each dot's edge.

    Parameters
    ----------
    picture
        Shape (H, W).
    noise
        Noise of its pixels.
    outlines
        Where the dots are, to about a fifth of their radius.
    lines
        Stripes that cross the dots: what they light up is not looked at.
    dark
        Dots are darker than their ground.

    Returns
    -------
    DotCentres
        The centre is that of the ellipse, which is the centroid of the disc's picture.

    Notes
    -----
    Only pixels within 4.5 px of the outline are used: the flat rest tells nothing of the centre.
    Sigma is the larger of what noise and scatter give by the fit, and of the spread of the
    centre over Gaussian kernels [1]_, which shows what a disc's model does not explain: a
    neighbour's light, a reflection's border.

    References
    ----------
    .. [1] "High-accuracy calibration of line-structured light vision sensor by correction of
       image deviation", Optics Express 27(4), 2019, section 2.1.1.
    """
    origin = np.rint(outlines.centre_px).astype(np.int64)
    first = disc.start(outlines, origin.astype(np.float64), _START_BLUR_PX)
    offset, ring = _ring(first, outlines)
    patches = Patches.cut(picture, box_smoothed(picture), noise, origin, offset, ring)
    _set_brightness(first, patches, offset)
    place, foot = patches.places_px(), _STRIPE_FOOT * np.abs(first[:, disc.HEIGHT])
    band = lit_by(lines, place, foot)
    fit = fit_patches(patches.without(band), first, disc.evaluate, disc.sound)
    seen = [patches.without(lit_by(lines, place, foot, scale)) for scale in SCALES_PX]
    spread = spread_over_scales(picture, seen, fit, disc.evaluate, disc.BLUR)
    by_noise = fit.sigma_px
    edge = ring & (np.abs(disc.inward_px(first, offset.astype(np.float64))) < 2.5)
    sign = -1.0 if dark else 1.0
    radius = outlines.radius_px
    parameters = fit.parameters
    ground = np.clip(parameters[:, disc.GROUND], 0.0, 255.0)
    sigma = np.maximum(by_noise, spread)
    return DotCentres(
        centre_px=parameters[:, :2] + origin,
        sigma_px=sigma,
        outlines=disc.outlines(parameters, origin.astype(np.float64)),
        height=np.minimum(sign * parameters[:, disc.HEIGHT], 255.0 - (1.0 - dark) * ground),
        ground=ground,
        slope=2.0 * radius * np.hypot(parameters[:, disc.GROUND_U], parameters[:, disc.GROUND_V]),
        scatter=fit.scatter,
        hidden=(edge & band).sum(axis=1) / np.maximum(edge.sum(axis=1), 1),
        clipped=(patches.clipped & ring).sum(axis=1) / np.maximum(ring.sum(axis=1), 1),
        trusted=_trusted(fit, first, sign, sigma),
    )


def _ring(first: FloatArray, outlines: Ellipses) -> tuple[IntArray, BoolArray]:
    """Return the offsets of pixels near any outline, and which are near which."""
    reach = int(np.ceil(float(outlines.axes_px.max()) + _EDGE_REACH_PX))
    side = np.arange(-reach, reach + 1)
    offset = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    ring = np.abs(disc.inward_px(first, offset.astype(np.float64))) <= _EDGE_REACH_PX
    used = ring.any(axis=0)
    return offset[used], ring[:, used]


def _set_brightness(first: FloatArray, patches: Patches, offset: IntArray) -> None:
    """Put the medians of what lies outside and inside the outlines into the first parameters."""
    inward = disc.inward_px(first, offset.astype(np.float64))
    used = patches.weight > 0.0
    for column, side in ((disc.GROUND, inward < -2.0), (disc.HEIGHT, inward > 2.0)):
        first[:, column] = masked_median(patches.samples, used & side)
    first[:, disc.HEIGHT] -= first[:, disc.GROUND]


def _trusted(fit: PatchFit, first: FloatArray, sign: float, sigma: FloatArray) -> BoolArray:
    found = disc.outlines(fit.parameters, np.zeros(2))
    wanted = disc.outlines(first, np.zeros(2))
    radius = wanted.radius_px
    moved = np.linalg.norm(found.centre_px - wanted.centre_px, axis=1)
    with np.errstate(invalid="ignore"):
        size = found.radius_px / radius
        stretch = found.axes_px[:, 1] / found.axes_px[:, 0]
    height = sign * fit.parameters[:, disc.HEIGHT]
    return np.asarray(
        (moved < 0.4 * radius)
        & (np.abs(np.log(size)) < np.log(1.35))
        & (stretch < 3.0)
        & (height > 3.0)
        & (sigma.max(axis=1) < _LARGEST_SIGMA * radius)
    )
