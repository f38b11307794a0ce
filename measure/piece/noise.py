"""How the points on a piece scatter: beyond what their pixels say, and together with neighbours."""

from collections.abc import Sequence

import numpy as np

from calib import FloatArray, IntArray, StripePoints, kernel_of

# Errors a distance r apart along the stripe are correlated by exp(-r^2 / 4 kernel^2): one in
# sqrt(4 pi) kernels of length is independent.
_KERNELS_A_POINT = 3.545
_MAX_LAG = 30
_CLIP_SIGMAS = 3.0
_BY_CHANCE_SIGMAS = 3.0
_MOST_HIDDEN = 0.7
_ROUNDS = 3


def scatter_of(
    face: IntArray,
    along_mm: FloatArray,
    outside_mm: FloatArray,
    own_mm: FloatArray,
    stripe: StripePoints,
    mm_per_px: FloatArray,
    terms: Sequence[int],
) -> FloatArray:
    """Return what to give each point in a mean that takes points for independent, mm, shape (N,).

    Parameters
    ----------
    face, along_mm, outside_mm
        Shape (N,), in order: side of the piece, place along it, distance from it.
    own_mm
        Shape (N,), standard deviation across the side by the noise of the pixels.
    stripe
        The same points in the picture.
    mm_per_px
        Shape (N,), length of profile that a pixel along the stripe shows.
    terms
        Of the polynomial that a side follows where the sensor or the piece is off a little, one
        for each side of the piece (`Piece.terms`).

    Notes
    -----
    Speckle moves the centre of a stripe by a share of its width, however bright it is; the share
    is told by the points, about a polynomial on each side. Neighbours share the pixels under the
    kernel, and the grain of the speckle: how far is taken from the kernel, or from the points
    where these say more. The polynomial follows what neighbours share: of a side of N points, r of
    which count as one, k terms hide k r / N of the variance.
    """
    rest = _off_smooth(face, along_mm, outside_mm, terms)
    points_a_term = np.bincount(face)[face] / np.array(terms)[face]
    width = own_mm / stripe.sigma_px * stripe.width_px
    run = by_kernel = _run_by_kernel(face, along_mm, stripe, mm_per_px)
    for _ in range(_ROUNDS):
        hidden = np.minimum(run / points_a_term, _MOST_HIDDEN)
        shown = rest / np.sqrt(1.0 - hidden)
        excess = np.mean(_clipped(shown / width) ** 2) - np.mean((own_mm / width) ** 2)
        sigma = np.hypot(own_mm, np.sqrt(max(float(excess), 0.0)) * width)
        run = np.maximum(by_kernel, _run_seen(face, _clipped(shown / sigma), float(hidden.mean())))
    return np.asarray(sigma * np.sqrt(run))


def _clipped(values: FloatArray) -> FloatArray:
    most = _CLIP_SIGMAS * 1.4826 * float(np.median(np.abs(values)))
    return np.clip(values, -most, most)


def _off_smooth(
    face: IntArray, along_mm: FloatArray, outside_mm: FloatArray, terms: Sequence[int]
) -> FloatArray:
    """Return the distances from a polynomial on each side."""
    rest = np.zeros(len(face))
    for index in np.unique(face):
        on = np.flatnonzero(face == index)
        off = along_mm[on] - along_mm[on].mean()
        powers = np.vander(off / max(float(np.abs(off).max()), 1e-6), terms[index])
        rest[on] = outside_mm[on] - powers @ np.linalg.lstsq(powers, outside_mm[on], rcond=None)[0]
    return rest


def _run_by_kernel(
    face: IntArray, along_mm: FloatArray, stripe: StripePoints, mm_per_px: FloatArray
) -> FloatArray:
    """Return how many neighbours count as one for they were read by one kernel, shape (N,)."""
    run = np.ones(len(face))
    for index in np.unique(face):
        on = np.flatnonzero(face == index)
        length_px = max(float(np.ptp(along_mm[on])) / float(np.median(mm_per_px[on])), 1.0)
        kernel = float(np.median(kernel_of(stripe.width_px[on], stripe.peak[on])))
        run[on] = max(1.0, _KERNELS_A_POINT * kernel * len(on) / length_px)
    return run


def _run_seen(face: IntArray, score: FloatArray, hidden: float) -> float:
    """Return 1 + 2 (sum of the correlations of neighbours), as far as they are there."""
    power = float(np.mean(score**2))
    if not (power > 0.0 and len(score) > 4 * _MAX_LAG):
        return 1.0
    length = 1.0
    for lag in range(1, _MAX_LAG + 1):
        same = face[lag:] == face[:-lag]
        if same.sum() <= _MAX_LAG:
            break
        seen = float(np.mean((score[lag:] * score[:-lag])[same])) / power
        # What the polynomials took is missing from all correlations alike.
        correlation = seen * (1.0 - hidden) + hidden
        if correlation < _BY_CHANCE_SIGMAS / np.sqrt(float(same.sum())):
            break
        length += 2.0 * correlation
    return length
