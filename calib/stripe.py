"""Sub-pixel location of the laser stripe, by Steger's method, with its uncertainty."""

from dataclasses import dataclass

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.noise import PixelNoise
from calib.ridge import (
    Ridge,
    inside,
    kernel_radius,
    ridge_at_shift,
    ridge_in_windows,
    windows_at,
)
from calib.stripe_profile import Profiles, fit_profiles, sample_across
from calib.stripe_seeds import SHRINK, StripeSeeds, find_seeds
from calib.views import Cause, StripePoints

KERNELS_PX = (1.5, 2.1, 3.0, 4.2, 6.0)
"""Widths of kernel; a point takes the one nearest to the width of its stripe."""

_SCALES_IF_CLIPPED = (0.75, 1.33)
_MOVES = 3
_HALF_PIXEL = 0.62
_PROFILE_REACH = 18
_WORST_MISFIT = 0.25
_STEEPEST_GROUND = 0.35


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
    flanks' brightness, shot noise included. Where the sensor clips, the spread over three kernels
    is taken instead where it is larger. Neighbours share noise: errors a distance r apart along the stripe are
    correlated by :math:`\exp(-r^2 / 4\sigma_g^2)`.

    A stripe that bends with radius R px is drawn inwards by about
    :math:`(\sigma_g^2) / 2R`.

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
    ridge = _RidgePoints.at(picture, seeds)
    points = ridge.points(picture, noise)
    return points.select(_worth_keeping(points, min_height) )
