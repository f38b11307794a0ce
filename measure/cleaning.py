"""Which points of a stripe are the wheel: the others are left out, each for a cause."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calib import BoolArray, Cause, FloatArray, IntArray, StripePoints
from measure.layers import one_layer
from measure.noise import Noise, noise_of, rest_of, robust_sigma
from measure.pieces import MIN_PIECE, pieces, sizes
from measure.template import Template

# A wheel wears inward; it lies outward where its profile is another than the reference: flanges
# of one railway are thicker by 4 mm than those of another, and metal that rolls over makes a lip.
_OUTSIDE_MM = (-14.0, 6.0)
_BEYOND_END_MM = 1.0
_SMOOTHING_POINTS = 21
_REJECT_SIGMAS = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """The points of the wheel, in order, and how noisy they are.

    Attributes
    ----------
    index
        Shape (K,): which points, from the flange back to the field side.
    along_mm
        Shape (K,), rising: place along the reference.
    noise
        How they scatter.
    left_out
        How many points were left out for which cause.
    """

    index: IntArray
    along_mm: FloatArray
    noise: Noise
    left_out: Mapping[Cause, int]


def keep_wheel(
    points_mm: FloatArray, sigma_mm: FloatArray, stripe: StripePoints, template: Template
) -> Kept:
    """Keep the points that make one profile near the reference.

    Parameters
    ----------
    points_mm
        Shape (N, 2), (y, z): already laid over the reference by the flange.
    sigma_mm
        Shape (N,), across the profile.
    stripe
        The same points in the picture.
    template
        The reference.

    Returns
    -------
    Kept
        Perhaps of no points.
    """
    along, outside, nearest = template.place(points_mm)
    in_band = np.flatnonzero(_can_be_wheel(along, outside, nearest, template))
    piece = pieces(stripe.centre_px[in_band], stripe.normal[in_band])
    hanging = in_band[sizes(piece) >= MIN_PIECE]
    unworn = template.is_unworn(along[hanging])
    first = hanging[one_layer(along[hanging], outside[hanging], unworn)]
    ordered = first[np.argsort(along[first], kind="stable")]

    kept = ordered[_inliers(along[ordered], outside[ordered], sigma_mm[ordered])]
    width = sigma_mm[kept] / stripe.sigma_px[kept] * stripe.width_px[kept]
    left_out = {
        Cause.STRAY_LIGHT: len(points_mm) - len(hanging),
        Cause.GLARE: len(hanging) - len(ordered),
        Cause.OUTLIER: len(ordered) - len(kept),
    }
    return Kept(
        index=kept,
        along_mm=along[kept],
        noise=noise_of(
            along[kept],
            outside[kept],
            sigma_mm[kept],
            width,
            template.wears_smoothly(along[kept]),
        ),
        left_out={cause: count for cause, count in left_out.items() if count},
    )


def _can_be_wheel(
    along_mm: FloatArray, outside_mm: FloatArray, nearest: IntArray, template: Template
) -> BoolArray:
    low, high = _OUTSIDE_MM
    on_profile = along_mm < template.along_mm[-1] + _BEYOND_END_MM
    # The back face does not wear: what lies behind it is something else.
    floor = np.where(nearest < template.back_count, -high, low)
    return np.asarray((outside_mm > floor) & (outside_mm < high) & on_profile)


def _inliers(along_mm: FloatArray, outside_mm: FloatArray, sigma_mm: FloatArray) -> BoolArray:
    """Tell which points lie where their neighbours say, within what is usual on this stripe."""
    score = rest_of(along_mm, outside_mm, _SMOOTHING_POINTS) / sigma_mm
    return np.asarray(np.abs(score) <= _REJECT_SIGMAS * max(1.0, robust_sigma(score)))
