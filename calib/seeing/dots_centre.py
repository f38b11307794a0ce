"""The centres of dots whose outlines are roughly known, and how well they are known."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing import disc
from calib.seeing.coherence import in_squares
from calib.seeing.dots_alike import alike, even_dots
from calib.seeing.dots_soft import (
    SOFT_FROM_PX,
    blur_px,
    edge_reach_px,
    without_neighbours,
)
from calib.seeing.ellipse import Ellipses
from calib.seeing.noise import PixelNoise
from calib.seeing.patch_fit import AGAIN, ROUGHLY, PatchFit, Prior, fit_patches
from calib.seeing.patch_spread import LARGEST_SCALE_PX, sigma_with_spread, spread_over_scales
from calib.seeing.patches import Patches, masked_median
from calib.seeing.resample import box_smoothed
from calib.seeing.stripe_lines import StripeLine, lit_by

_EDGE_REACH_PX = 4.5
_START_BLUR_PX = 1.5
_LARGEST_SIGMA = 0.15  # of the radius: beyond, it is not sure that this is a dot
_CLIPPED_INSIDE = 0.1
_UNMIXING_ROUNDS = 2
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
    parameters, origin
        Shapes (N, disc.COUNT) and (N, 2): the discs themselves.
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
    parameters: FloatArray
    origin: IntArray

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
    Each dot is fitted twice: by itself, and with what the others say of its form, its blur and
    its dome, which weighs the more, the more what is left over hangs together.
    Sigma is the larger of the fit's and of half the spread of the centre over Gaussian
    kernels [1]_, which shows what a disc's model does not explain: a neighbour's light, a
    reflection's border.

    References
    ----------
    .. [1] "High-accuracy calibration of line-structured light vision sensor by correction of
       image deviation", Optics Express 27(4), 2019, section 2.1.1.
    """
    origin = np.rint(outlines.centre_px).astype(np.int64)
    softness = blur_px(picture, outlines)
    soft = softness >= SOFT_FROM_PX
    blur = softness if soft else _START_BLUR_PX
    reach_px = max(_EDGE_REACH_PX, edge_reach_px(outlines, blur)) if soft else _EDGE_REACH_PX
    first = disc.start(outlines, origin.astype(np.float64), blur)
    offset, ring = _ring(first, outlines, reach_px)
    patches = Patches.cut(picture, box_smoothed(picture), noise, origin, offset, ring)
    _set_brightness(first, patches, offset)
    place, foot = patches.places_px(), _STRIPE_FOOT * np.abs(first[:, disc.HEIGHT])
    band = lit_by(lines, place, foot)
    sign = -1.0 if dark else 1.0
    if soft:
        patches = _unmixed(patches, band, first, outlines.radius_px)
    fit, prior = _fit_twice(patches.without(band), first, outlines.radius_px, sign)
    seen = patches.without(lit_by(lines, place, foot, LARGEST_SCALE_PX))
    spread = spread_over_scales(picture, seen, fit, disc.evaluate, disc.BLUR, prior)
    edge = ring & (np.abs(disc.inward_px(first, offset.astype(np.float64))) < 2.5)
    radius = outlines.radius_px
    parameters = fit.parameters
    ground = np.clip(parameters[:, disc.GROUND], 0.0, 255.0)
    sigma = sigma_with_spread(fit.sigma_px, spread)
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
        parameters=parameters,
        origin=origin,
    )


def _ring(first: FloatArray, outlines: Ellipses, reach_px: float) -> tuple[IntArray, BoolArray]:
    """Return the offsets of pixels near any outline, and which are near which."""
    reach = int(np.ceil(float(outlines.axes_px.max()) + reach_px))
    side = np.arange(-reach, reach + 1)
    offset = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    offset = in_squares(offset)
    ring = np.abs(disc.inward_px(first, offset.astype(np.float64))) <= reach_px
    used = ring.any(axis=0)
    return offset[used], ring[:, used]


def _set_brightness(first: FloatArray, patches: Patches, offset: IntArray) -> None:
    """Put the medians of what lies outside and inside the outlines into the first parameters."""
    inward = disc.inward_px(first, offset.astype(np.float64))
    used = patches.weight > 0.0
    for column, side in ((disc.GROUND, inward < -2.0), (disc.HEIGHT, inward > 2.0)):
        first[:, column] = masked_median(patches.samples, used & side)
    first[:, disc.HEIGHT] -= first[:, disc.GROUND]


def _unmixed(patches: Patches, band: BoolArray, first: FloatArray, radius: FloatArray) -> Patches:
    """Return windows without the light that soft dots throw into each other's."""
    alone, start = patches, first
    even = even_dots(first, radius, np.zeros(len(first), dtype=bool))
    for _ in range(_UNMIXING_ROUNDS):
        fit = fit_patches(alone.without(band), start, disc.evaluate, disc.sound, even, ROUGHLY)
        start = fit.parameters
        alone = without_neighbours(patches, start)
    return alone


def _fit_twice(
    patches: Patches, first: FloatArray, radius: FloatArray, sign: float
) -> tuple[PatchFit, Prior]:
    """Fit each dot by itself, and again with what all of them say."""
    inside = disc.inward_px(first, patches.offset.astype(np.float64)) > 2.0
    inside &= patches.weight > 0.0
    clipped = (patches.clipped & inside).sum(axis=1) > _CLIPPED_INSIDE * inside.sum(axis=1)
    even = even_dots(first, radius, clipped)
    rough = fit_patches(patches, first, disc.evaluate, disc.sound, even, ROUGHLY)
    usable = _trusted(rough, first, sign, rough.sigma_px)
    place = rough.parameters[:, :2] + patches.origin
    told = alike(rough.parameters, place, radius, usable, clipped)
    prior = replace(told, noise=np.maximum(rough.coherence, 1.0))
    return fit_patches(patches, rough.parameters, disc.evaluate, disc.sound, prior, AGAIN), prior


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
