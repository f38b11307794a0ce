"""Sub-pixel location of the laser stripe, by Steger's method, with its uncertainty."""

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import PixelNoise
from calib.seeing.resample import shrunk
from calib.seeing.ridge import FRACTIONS, inside, kernel_radius, ridge_between_pixels, windows_at
from calib.seeing.stripe_order import running_mean
from calib.seeing.stripe_profile import Profiles, fit_profiles, sample_across
from calib.seeing.stripe_seeds import StripeSeeds, find_seeds
from calib.views import Cause, StripePoints

KERNELS_PX = (1.5, 2.1, 3.0, 4.2, 6.0)
"""Widths of kernel; a point takes the one nearest to the width of its stripe."""

_SCALES_IF_CLIPPED = (0.75, 1.33)
_WIDEST_KERNEL_PX = 4.5
_CLIPPED_SIGMA_PX = 0.006  # measured: what the sampling of a clipped edge leaves
_MOST_STEPS = 3
_CLOSE_STEP_PX = 0.2
_PROFILE_REACH = 18
_SLOPE_HALF_WINDOW = 6
_WORST_MISFIT = 0.25
_STEEPEST_GROUND = 1.0


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
        caller to tell.

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
    seeds = find_seeds(
        picture, noise, region=region, min_height=min_height, min_length_px=min_length_px
    )
    place, normal = seeds.place_px.reshape(-1, 2), np.repeat(seeds.normal, seeds.group, axis=0)
    samples = sample_across(picture, place, normal, _PROFILE_REACH)
    fits = fit_profiles(samples.reshape(len(seeds), seeds.group, samples.shape[1]).mean(axis=1))
    trusted = np.flatnonzero(_is_stripe(fits, noise, min_height))
    member = (trusted[:, None] * seeds.group + np.arange(seeds.group)).ravel()
    profiles = fits.picked(np.repeat(trusted, seeds.group))
    start = place[member] + profiles.centre_px[:, None] * normal[member]
    slope = np.repeat(_ground_slope(fits, seeds, trusted), seeds.group, axis=0)
    return _settled(picture, noise, start, slope, profiles)


def _ground_slope(fits: Profiles, seeds: StripeSeeds, trusted: IntArray) -> FloatArray:
    """Return the gradient of the ground, shape (T, 2), smoothed along the stripe.

    A profile alone tells it so poorly that taking it off would add noise to the centres. One
    that is no bell on a slope, for a mark is near, has little weight.
    """
    weight = 1.0 / (fits.misfit[trusted] ** 2 + 0.25)
    slope = fits.slope[trusted, None] * seeds.normal[trusted]
    total = running_mean(
        np.column_stack([weight[:, None] * slope, weight]),
        seeds.place_px[trusted].mean(axis=1),
        half_window=_SLOPE_HALF_WINDOW,
        gap_px=3.0 * seeds.group,
    )
    return np.asarray(total[:, :2] / total[:, 2:])


def kernel_of(width_px: FloatArray) -> FloatArray:
    """Return the kernel that a stripe of each width, not clipped, is located with."""
    return np.array(KERNELS_PX)[_nearest_kernel(width_px)]


def _nearest_kernel(wanted_px: FloatArray) -> IntArray:
    ratio = np.log(wanted_px[:, None] / np.array(KERNELS_PX))
    return np.asarray(np.abs(ratio).argmin(axis=1), dtype=np.int64)


def _kernel_wanted(profiles: Profiles) -> FloatArray:
    """Return the width of kernel that suits each profile.

    That of the profile; on a flat, clipped top of half-width h Steger's condition asks for
    at least h / sqrt(3), and noise for a little more.
    """
    over = np.maximum(profiles.height / np.maximum(250.0 - profiles.ground, 10.0), 1.0)
    half_top = profiles.width_px * np.sqrt(2.0 * np.log(over))
    return np.maximum(profiles.width_px, 0.75 * half_top)


def _is_stripe(fits: Profiles, noise: PixelNoise, min_height: float) -> BoolArray:
    """Return which profiles are a bright line on both sides of which it is dark."""
    grain = np.sqrt(noise.variance(fits.ground + fits.height))
    return np.asarray(
        (fits.height >= min_height)
        & (fits.misfit <= _WORST_MISFIT * np.minimum(fits.height, 255.0) + grain)
        & (np.abs(fits.slope) * 6.0 * fits.width_px <= _STEEPEST_GROUND * fits.height)
    )


def _settled(
    picture: Picture,
    noise: PixelNoise,
    start: FloatArray,
    slope: FloatArray,
    profiles: Profiles,
) -> StripePoints:
    """Go from near the ridge to its top, each point with the kernel of its width."""
    choice = _nearest_kernel(_kernel_wanted(profiles))
    centre, across = np.empty_like(start), np.empty_like(start)
    sigma = np.full(len(start), np.inf)
    for k in np.unique(choice):
        index, kernel = np.flatnonzero(choice == k), KERNELS_PX[k]
        centre[index], across[index], curvature = _tops(picture, start[index], slope[index], kernel)
        index, curvature = index[curvature < 0.0], curvature[curvature < 0.0]
        one = profiles.picked(index)
        sigma[index] = sigma_by_eq9(one, noise, kernel)
        if not one.saturated.any():
            continue
        clipped = index[one.saturated]
        spread = _spread_over_scales(
            picture, centre[clipped], across[clipped], slope[clipped], kernel
        )
        plain = _sigma_by_curvature(one, noise, kernel, curvature)[one.saturated]
        sigma[clipped] = np.maximum(np.maximum(spread, plain), _CLIPPED_SIGMA_PX)
    keep = _one_a_pixel(centre, np.isfinite(sigma))
    kept = profiles.picked(keep)
    return StripePoints(
        centre_px=centre[keep],
        normal=across[keep],
        sigma_px=sigma[keep],
        width_px=kept.width_px,
        peak=kept.height,
        saturated=kept.saturated,
        cause=tuple(Cause.SATURATED if s else Cause.NONE for s in kept.saturated),
    )


def _tops(
    picture: Picture, start: FloatArray, slope: FloatArray, kernel: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the ridge's top near each start, the normal and the curvature across it there.

    `slope` is the gradient of the ground, shape (N, 2). Curvature 0 tells that there is no top.
    A wide kernel works on the picture at half its size: as exact, and a quarter of the work.
    """
    if kernel > _WIDEST_KERNEL_PX:
        place, normal, curvature = _tops(
            shrunk(picture, 2), 0.5 * (start - 0.5), 2.0 * slope, 0.5 * kernel
        )
        return 2.0 * place + 0.5, normal, 0.25 * curvature
    place, normal = start.copy(), np.zeros_like(start)
    curvature = np.zeros(len(start))
    todo, radius = np.arange(len(start)), kernel_radius(kernel)
    for _ in range(_MOST_STEPS):
        pixel = np.rint(place[todo]).astype(np.int64)
        clear = inside(picture.shape, pixel, radius)
        todo, pixel = todo[clear], pixel[clear]
        fraction = np.rint((place[todo] - pixel) * FRACTIONS).astype(np.int64)
        place[todo] = pixel + fraction / FRACTIONS
        ridge = ridge_between_pixels(windows_at(picture, pixel, radius), fraction, kernel)
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


def _sigma_by_curvature(
    profiles: Profiles, noise: PixelNoise, kernel: float, curvature: FloatArray
) -> FloatArray:
    """Return the same for a clipped stripe: Eq. 7 with the curvature that is really there."""
    ground = np.minimum(profiles.ground, 255.0)
    variance = noise.variance(0.5 * (ground + 255.0)) / (8.0 * np.pi * kernel**4)
    return np.asarray(np.sqrt(variance) / np.abs(curvature))


def _spread_over_scales(
    picture: Picture, centre: FloatArray, normal: FloatArray, slope: FloatArray, kernel: float
) -> FloatArray:
    """Return how far the top moves along the normal, rms, as the kernel grows and shrinks."""
    offsets = [np.zeros(len(centre))]
    for scale in _SCALES_IF_CLIPPED:
        place, _, curvature = _tops(picture, centre, slope, scale * kernel)
        moved = ((place - centre) * normal).sum(axis=1)
        offsets.append(np.where(curvature < 0.0, moved, kernel))
    return np.asarray(np.std(offsets, axis=0))


def _one_a_pixel(centre_px: FloatArray, usable: BoolArray) -> IntArray:
    """Return, in order, the index of one usable point for every pixel that holds some."""
    index = np.flatnonzero(usable)
    pixel = np.rint(centre_px[index]).astype(np.int64)
    first = np.unique((pixel[:, 1] << 32) + pixel[:, 0], return_index=True)[1]
    return np.asarray(index[np.sort(first)])
