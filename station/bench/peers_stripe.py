"""Peers for finding the stripe: Steger's method by scikit-image's Hessian, and `ridge-detector`."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, Picture, locate_stripe
from station.bench.peers import peer


@dataclass(frozen=True, slots=True, eq=False)
class Ridges:
    """Centres of ridges, shape (N, 2), and their sigma across, shape (N,), where it is told, px."""

    centre_px: FloatArray
    sigma_px: FloatArray | None = None


Extract = Callable[[Picture], Ridges]

# What a careful user would set for a stripe of sigma 2 px and some 100 counts: the peers do not
# find out by themselves.
_KERNEL_PX = 2.0
_LEAST_CURVATURE = 4.0
_LINE_WIDTH_PX = 5
_CONTRASTS = (20, 60)
_LEAST_LENGTH_PX = 24


def extractors() -> dict[str, Extract | None]:
    """Return who finds stripes; None for a peer that is not installed."""
    return {
        "treadline, locate_stripe": _ours,
        "scikit-image, hessian_matrix": _by_hessian(),
        "ridge-detector": _by_ridge_detector(),
    }


def _ours(picture: Picture) -> Ridges:
    points = locate_stripe(picture)
    return Ridges(points.centre_px, points.sigma_px)


def _by_hessian() -> Extract | None:
    feature, filters = peer("skimage.feature"), peer("skimage.filters")
    if feature is None or filters is None:
        return None

    def extract(picture: Picture) -> Ridges:
        light = picture.astype(np.float64)
        vv, uv, uu = feature.hessian_matrix(
            light, sigma=_KERNEL_PX, order="rc", use_gaussian_derivatives=False
        )
        slope_v, slope_u = np.gradient(filters.gaussian(light, _KERNEL_PX, preserve_range=True))
        return Ridges(ridge_points(np.stack([slope_u, slope_v]), np.stack([uu, uv, vv])))

    return extract


def ridge_points(gradient: FloatArray, hessian: FloatArray) -> FloatArray:
    """Return the points where Steger's offset stays inside its pixel (the paper's Eq. 2), (N, 2).

    Parameters
    ----------
    gradient
        Shape (2, H, W): along u, along v.
    hessian
        Shape (3, H, W): uu, uv, vv.
    """
    mean = 0.5 * (hessian[0] + hessian[2])
    half = np.hypot(0.5 * (hessian[0] - hessian[2]), hessian[1])
    v, u = np.nonzero(mean - half < -_LEAST_CURVATURE)
    uu, uv, vv = hessian[:, v, u]
    angle = 0.5 * np.arctan2(2.0 * uv, uu - vv) + 0.5 * np.pi
    across = np.column_stack([np.cos(angle), np.sin(angle)])
    curvature = uu * across[:, 0] ** 2 + 2.0 * uv * across.prod(axis=1) + vv * across[:, 1] ** 2
    offset = -(gradient[:, v, u] * across.T).sum(axis=0) / curvature
    step = offset[:, None] * across
    inside = (np.abs(step) <= 0.5).all(axis=1)
    return np.asarray((np.column_stack([u, v]) + step)[inside])


def _by_ridge_detector() -> Extract | None:
    module = peer("ridge_detector")
    if module is None:
        return None

    def extract(picture: Picture) -> Ridges:
        detector = module.RidgeDetector(
            line_widths=[_LINE_WIDTH_PX],
            low_contrast=_CONTRASTS[0],
            high_contrast=_CONTRASTS[1],
            min_len=_LEAST_LENGTH_PX,
            dark_line=False,
            estimate_width=False,
        )
        detector.detect_lines(picture)
        found = [np.column_stack([line.col, line.row]) for line in detector.contours]
        return Ridges(np.concatenate([np.empty((0, 2)), *found]))

    return extract
