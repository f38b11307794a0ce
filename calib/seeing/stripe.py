"""Sub-pixel location of the laser stripe, by Steger's method, with its uncertainty."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import PixelNoise
from calib.seeing.resample import shrunk
from calib.seeing.ridge import FRACTIONS, inside, kernel_radius, ridge_between_pixels
from calib.seeing.stripe_order import running_mean
from calib.seeing.stripe_profile import Profiles, fit_profiles, sample_across, stands_out
from calib.seeing.stripe_seeds import StripeSeeds, find_seeds
from calib.views import Cause, StripePoints

KERNELS_PX = (1.5, 2.1, 3.0, 4.2, 6.0)
"""Widths of kernel; a point takes the one nearest to the width of its stripe."""

_SCALES_IF_CLIPPED = (0.75, 1.33)
_WIDEST_KERNEL_PX = 4.5
_CLIPPED_SIGMA_PX = 0.006  # measured: what the sampling of a clipped edge leaves
_LARGEST_CLIPPED_SIGMA_PX = 0.2  # a top that moves more from kernel to kernel is not the stripe's
_LARGEST_DOUBT_PX = 0.15  # by the ground: more has a mark or a reflection beside
_MOST_STEPS = 3
_CLOSE_STEP_PX = 0.2
_PROFILE_REACH = 18
_SLOPE_HALF_WINDOW = 6
_WORST_MISFIT = 0.25
_STEEPEST_GROUND = 1.0
_WIDEST_PX = 0.5 * _PROFILE_REACH  # of a wider bell the profile does not show the feet
_BRIGHTEST_GROUND = 155.0  # under a clipped stripe: above, what is left of its flanks misleads
_CAUSES = np.array([Cause.NONE, Cause.SATURATED], dtype=object)  # by whether the sensor clips


def locate_stripe(
    picture: Picture,
    *,
    region: BoolArray | None = None,
    noise: PixelNoise | None = None,
    min_height: float = 6.0,
    min_length_px: float = 24.0,
) -> StripePoints:
    r"""Locate the laser stripe wherever a picture shows it.

    Parameters
    ----------
    picture
        Shape (H, W), 8 bit.
    region
        Shape (H, W), where to look; None is everywhere.
    noise
        Noise of the pixels; None is told from the picture.
    min_height
        Counts over the ground; dimmer ridges are left out.
    min_length_px
        Shorter ridges are left out.

    Returns
    -------
    StripePoints
        About one point per pixel of the stripe's length. A picture without a stripe gives none.
        Any bright line as narrow as a stripe is one: which of them the laser drew is for the
        caller to tell. Left out is where the sensor clips because the ground is bright, where a
        clipped top moves from kernel to kernel, and where a step of the ground is too near.

    Raises
    ------
    ValueError
        If `picture` is not 8 bit and two-dimensional, or `region` is of another shape.

    Notes
    -----
    Steger's method [1]_ with a kernel as wide as the stripe (:math:`\sigma_g = \sigma_w`: the
    width at which the points along a piece of stripe tell its place best). The slope of the
    ground, which would move the top of the smoothed profile, is taken off the gradient. Across
    the stripe a centre then scatters by Eq. 9 of [2]_,

    .. math:: \sigma_{c_0}^2 = \frac{(\sigma_w^2+\sigma_g^2)^3}{8\pi\sigma_g^4\sigma_w^2}
              \cdot\frac{\sigma_N^2}{M^2}

    with :math:`\sigma_w` and :math:`M` fitted to the profile and :math:`\sigma_N` that of the
    flanks' brightness, shot noise included. Where the sensor clips, Eq. 9 does not hold: there the
    spread over three kernels is taken, and Eq. 7 with the curvature really found if that is
    larger. Neighbours share noise: errors a distance r apart along the stripe are correlated by
    :math:`\exp(-r^2 / 4\sigma_g^2)`.

    Smoothing draws a stripe that bends with radius R inwards, by :math:`\sigma_g^2 / 2R`.

    References
    ----------
    .. [1] C. Steger, "An unbiased detector of curvilinear structures", IEEE Transactions on
       Pattern Analysis and Machine Intelligence 20(2), 1998.
    .. [2] "High-accuracy calibration of line-structured light vision sensor by correction of
       image deviation", Optics Express 27(4), 2019.
    """
    if picture.ndim != 2 or picture.dtype != np.uint8:
        raise ValueError(
            f"picture must be 8 bit of shape (H, W), got {picture.dtype} of shape {picture.shape}"
        )
    if region is not None and region.shape != picture.shape:
        raise ValueError(f"region must have shape {picture.shape}, got {region.shape}")
    if noise is None:
        noise = PixelNoise.from_picture(picture)
    half = shrunk(picture, 2)
    seeds = find_seeds(
        half, noise, region=region, min_height=min_height, min_length_px=min_length_px
    )
    samples = sample_across(picture, seeds.place_px, seeds.normal, _PROFILE_REACH)
    outstanding = np.flatnonzero(stands_out(samples, 0.5 * min_height))
    fits = fit_profiles(samples[outstanding])
    sound = np.flatnonzero(_is_stripe(fits, noise, min_height))
    fits, seeds = fits.picked(sound), seeds.picked(outstanding[sound])
    start = seeds.place_px + (fits.centre_px[:, None] * seeds.normal)[:, None]
    group = np.repeat(np.arange(len(seeds)), seeds.group)
    slope = _ground_slope(fits, seeds)[group]
    scales = _Scales(picture, half)
    return _settled(scales, noise, start.reshape(-1, 2), slope, fits.picked(group))


@dataclass(frozen=True, slots=True, eq=False)
class _Scales:
    """A picture, and the same at half its size."""

    full: Picture
    half: Picture


def _ground_slope(fits: Profiles, seeds: StripeSeeds) -> FloatArray:
    """Return the gradient of the ground, shape (G, 2), smoothed along the stripe.

    A profile alone tells it so poorly that taking it off would add noise to the centres. One
    that is no bell on a slope, for a mark is near, has little weight.
    """
    weight = 1.0 / (fits.misfit**2 + 0.25)
    slope = fits.slope[:, None] * seeds.normal
    total = running_mean(
        np.column_stack([weight[:, None] * slope, weight]),
        seeds.place_px.mean(axis=1),
        half_window=_SLOPE_HALF_WINDOW,
        gap_px=3.0 * seeds.group,
    )
    return np.asarray(total[:, :2] / total[:, 2:])


def kernel_of(width_px: FloatArray, peak: FloatArray | None = None) -> FloatArray:
    """Return the kernel that each point of a stripe is located with.

    Parameters
    ----------
    width_px
        Shape (N,), of the points.
    peak
        Shape (N,), of the points, on a dark ground: the sensor clips some. None for a stripe
        that it does not clip.
    """
    if peak is not None:
        width_px = _kernel_wanted(width_px, peak / 250.0)
    return np.array(KERNELS_PX)[_nearest_kernel(width_px)]


def _nearest_kernel(wanted_px: FloatArray) -> IntArray:
    ratio = np.log(wanted_px[:, None] / np.array(KERNELS_PX))
    return np.asarray(np.abs(ratio).argmin(axis=1), dtype=np.int64)


def _kernel_wanted(width_px: FloatArray, over: FloatArray) -> FloatArray:
    """Return the width of kernel that suits profiles `over` times as high as the sensor shows.

    That of the profile; on a flat, clipped top of half-width h Steger's condition asks for
    at least h / sqrt(3), and noise for a little more.
    """
    half_top = width_px * np.sqrt(2.0 * np.log(np.maximum(over, 1.0)))
    return np.asarray(np.maximum(width_px, 0.75 * half_top))


def _is_stripe(fits: Profiles, noise: PixelNoise, min_height: float) -> BoolArray:
    """Return which profiles are a bright line on both sides of which it is dark.

    Where the sensor clips a stripe because it lies in glare, the glare's own slope and bend are
    clipped as well: by its flanks alone, above a ground of 160 counts, a centre was off by 2 to 4
    sigmas, and by 0.7 px at the rim of the glare's core.
    """
    grain = np.sqrt(noise.variance(fits.ground + fits.height))
    return np.asarray(
        (fits.height >= min_height)
        & (fits.misfit <= _WORST_MISFIT * np.minimum(fits.height, 255.0) + grain)
        & (np.abs(fits.slope) * 6.0 * fits.width_px <= _STEEPEST_GROUND * fits.height)
        & (fits.width_px <= _WIDEST_PX)
        & ~(fits.saturated & (fits.ground > _BRIGHTEST_GROUND))
    )


def _settled(
    scales: _Scales,
    noise: PixelNoise,
    start: FloatArray,
    slope: FloatArray,
    profiles: Profiles,
) -> StripePoints:
    """Go from near the ridge to its top, each point with the kernel of its width."""
    over = profiles.height / np.maximum(250.0 - profiles.ground, 10.0)
    choice = _nearest_kernel(_kernel_wanted(profiles.width_px, over))
    centre, across = np.empty_like(start), np.empty_like(start)
    sigma = np.full(len(start), np.inf)
    for k in np.unique(choice):
        index, kernel = np.flatnonzero(choice == k), KERNELS_PX[k]
        centre[index], across[index], curvature = _tops(scales, start[index], slope[index], kernel)
        index, curvature = index[curvature < 0.0], curvature[curvature < 0.0]
        one = profiles.picked(index)
        sigma[index] = sigma_by_eq9(one, noise, kernel)
        clipped = index[one.saturated]
        if clipped.size > 0:
            spread = _spread_over_scales(
                scales, centre[clipped], across[clipped], slope[clipped], kernel
            )
            plain = _sigma_by_curvature(one, noise, kernel, curvature)[one.saturated]
            sigma[clipped] = np.maximum(np.maximum(spread, plain), _CLIPPED_SIGMA_PX)
    taken_off = np.abs((slope * across).sum(axis=1))
    doubt = _doubt_by_ground(profiles, noise, taken_off, choice)
    largest = np.where(profiles.saturated, _LARGEST_CLIPPED_SIGMA_PX, np.inf)
    usable = (sigma < largest) & (doubt <= _LARGEST_DOUBT_PX)
    keep = _one_a_pixel(centre, usable)
    kept = profiles.picked(keep)
    return StripePoints(
        centre_px=centre[keep],
        normal=across[keep],
        sigma_px=sigma[keep],
        width_px=kept.width_px,
        peak=kept.height,
        saturated=kept.saturated,
        cause=tuple(_CAUSES[kept.saturated.astype(np.int64)]),
    )


def _tops(
    scales: _Scales, start: FloatArray, slope: FloatArray, kernel: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the ridge's top near each start, the normal and the curvature across it there.

    `slope` is the gradient of the ground, shape (N, 2). Curvature 0 tells that there is no top.
    A wide kernel works on the picture at half its size: as exact, and a quarter of the work.
    """
    if kernel > _WIDEST_KERNEL_PX:
        place, normal, curvature = _tops_in(
            scales.half, 0.5 * (start - 0.5), 2.0 * slope, 0.5 * kernel
        )
        return 2.0 * place + 0.5, normal, 0.25 * curvature
    return _tops_in(scales.full, start, slope, kernel)


def _tops_in(
    picture: Picture, start: FloatArray, slope: FloatArray, kernel: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the same in one picture: steps across the ridge until they are short."""
    place, normal = start.copy(), np.zeros_like(start)
    curvature = np.zeros(len(start))
    todo, radius = np.arange(len(start)), kernel_radius(kernel)
    for _ in range(_MOST_STEPS):
        pixel = np.rint(place[todo]).astype(np.int64)
        clear = inside(picture.shape, pixel, radius)
        todo, pixel = todo[clear], pixel[clear]
        fraction = np.rint((place[todo] - pixel) * FRACTIONS).astype(np.int64)
        place[todo] = pixel + fraction / FRACTIONS
        ridge = ridge_between_pixels(picture, pixel, fraction, kernel)
        ground = (slope[todo] * ridge.normal).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -(ridge.gradient - ground) / ridge.curvature
        good = (ridge.curvature < 0.0) & (np.abs(step) < 2.0 * kernel)
        todo, step, across = todo[good], step[good], ridge.normal[good]
        place[todo] += step[:, None] * across
        normal[todo] = across
        close = np.abs(step) <= _CLOSE_STEP_PX
        curvature[todo[close]] = ridge.curvature[good][close]
        todo = todo[~close]
        if todo.size == 0:
            break
    return place, normal, curvature


def sigma_by_eq9(profiles: Profiles, noise: PixelNoise, kernel: float) -> FloatArray:
    """Return the standard deviation of a centre along its normal, shape (N,), px.

    The noise is that of the brightness which the kernel weighs: at the flanks.
    """
    w2, g2 = profiles.width_px**2, kernel**2
    height = np.minimum(profiles.height, 255.0)
    flank = profiles.ground + height * (1.0 + 0.5 * g2 / w2) ** -1.5
    variance = (w2 + g2) ** 3 / (8.0 * np.pi * g2**2 * w2)
    return np.asarray(np.sqrt(variance * noise.variance(flank)) / height)


def _doubt_by_ground(
    profiles: Profiles, noise: PixelNoise, slope: FloatArray, choice: IntArray
) -> FloatArray:
    """Return how far a slope of the ground wrongly taken off may move centres, shape (N,), px.

    A step beside the stripe, as a mark's edge, looks like a slope to the fit, but leaves more than
    noise: a slope is not better known than one that would leave as much.
    """
    w2, g2 = profiles.width_px**2, np.array(KERNELS_PX)[choice] ** 2
    height = np.minimum(profiles.height, 255.0)
    left = profiles.misfit**2 - noise.variance(profiles.ground + height)
    doubt = np.sqrt(3.0 * np.maximum(left, 0.0)) / profiles.reach_px
    per_slope = (w2 + g2) ** 1.5 / (height * profiles.width_px)
    return np.asarray(per_slope * np.minimum(slope, doubt))


def _sigma_by_curvature(
    profiles: Profiles, noise: PixelNoise, kernel: float, curvature: FloatArray
) -> FloatArray:
    """Return the same for a clipped stripe: Eq. 7 with the curvature that is really there."""
    ground = np.minimum(profiles.ground, 255.0)
    variance = noise.variance(0.5 * (ground + 255.0)) / (8.0 * np.pi * kernel**4)
    return np.asarray(np.sqrt(variance) / np.abs(curvature))


def _spread_over_scales(
    scales: _Scales, centre: FloatArray, normal: FloatArray, slope: FloatArray, kernel: float
) -> FloatArray:
    """Return how far the top moves along the normal, rms, as the kernel grows and shrinks."""
    offsets = [np.zeros(len(centre))]
    for scale in _SCALES_IF_CLIPPED:
        place, _, curvature = _tops(scales, centre, slope, scale * kernel)
        moved = ((place - centre) * normal).sum(axis=1)
        offsets.append(np.where(curvature < 0.0, moved, kernel))
    return np.asarray(np.std(offsets, axis=0))


def _one_a_pixel(centre_px: FloatArray, usable: BoolArray) -> IntArray:
    """Return, in order, the index of one usable point for every pixel that holds some."""
    index = np.flatnonzero(usable)
    pixel = np.rint(centre_px[index]).astype(np.int64)
    first = np.unique((pixel[:, 1] << 32) + pixel[:, 0], return_index=True)[1]
    return np.asarray(index[np.sort(first)])
