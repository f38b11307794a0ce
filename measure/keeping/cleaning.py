"""Which points of a stripe are the wheel: the others are left out, each for a cause."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from calib import BoolArray, Cause, FloatArray, IntArray, StripePoints
from measure.keeping.bumps import bumps
from measure.keeping.layers import one_layer
from measure.keeping.melted import melted
from measure.keeping.noise import Noise, noise_of, rest_of
from measure.keeping.upright import false_back
from measure.placing.belonging import can_be_wheel, mostly_wheel
from measure.placing.pieces import MIN_PIECE, pieces, sizes
from measure.placing.template import Template

_SMOOTHING_POINTS, _AROUND_POINTS = 21, 31
_REJECT_SIGMAS = 4.0
_ALONE_SHARE = 0.9


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
    inside = can_be_wheel(along, outside, nearest, template)
    whole = pieces(stripe.centre_px, stripe.normal)
    in_band = np.flatnonzero(inside & mostly_wheel(inside, along, whole, template))
    hanging = in_band[sizes(whole) >= MIN_PIECE] if inside.all() else _no_specks(in_band, stripe)
    unworn = template.is_unworn(along[hanging])
    first = hanging[one_layer(along[hanging], outside[hanging], unworn)]
    apart = first[~melted(stripe.select(first))]
    single = _no_specks(apart, stripe) if len(apart) < len(first) else first
    ordered = single[np.argsort(along[single], kind="stable")]
    width = sigma_mm / stripe.sigma_px * stripe.width_px

    def noise(index: IntArray) -> Noise:
        smooth = template.wears_smoothly(along[index])
        return noise_of(along[index], outside[index], sigma_mm[index], width[index], smooth)

    alone = len(ordered) >= _ALONE_SHARE * len(points_mm)
    false = false_back(points_mm[ordered], nearest[ordered], template, alone=alone)
    upright = ordered[~false]
    sigma = noise(upright).sigma_mm
    steady = _inliers(along[upright], outside[upright], sigma)
    calm, sigma = upright[steady], sigma[steady]
    smooth = template.wears_smoothly(along[calm])
    kept = calm[~bumps(along[calm], outside[calm], sigma, smooth)]
    left_out = {
        Cause.STRAY_LIGHT: len(points_mm) - len(hanging) + len(ordered) - len(upright),
        Cause.GLARE: len(hanging) - len(ordered),
        Cause.OUTLIER: len(upright) - len(kept),
    }
    return Kept(
        index=kept,
        along_mm=along[kept],
        noise=noise(kept),
        left_out={cause: count for cause, count in left_out.items() if count},
    )


def _no_specks(index: IntArray, stripe: StripePoints) -> IntArray:
    """Return those of some points that hang together with enough others of them."""
    return index[sizes(pieces(stripe.centre_px[index], stripe.normal[index])) >= MIN_PIECE]


def _inliers(along_mm: FloatArray, outside_mm: FloatArray, sigma_mm: FloatArray) -> BoolArray:
    """Tell which points lie where their neighbours say, within what is usual beside them.

    Usual is their own sigma with the stripe's speckle, or the scatter around if it is larger:
    where light grazes, and where wear has left edges, all points are rough and none is wrong.
    """
    score = rest_of(along_mm, outside_mm, _SMOOTHING_POINTS) / sigma_mm
    around = 1.4826 * median_filter(np.abs(score), _AROUND_POINTS, mode="nearest")
    return np.asarray(np.abs(score) <= _REJECT_SIGMAS * np.maximum(1.0, around))
