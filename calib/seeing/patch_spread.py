"""How far the centre of a mark moves when its picture is smoothed."""

from dataclasses import replace

import numpy as np

from calib.arrays import FloatArray, Picture
from calib.seeing.patch_fit import Evaluate, PatchFit, Prior, Seen
from calib.seeing.patches import Patches
from calib.seeing.resample import smoothed

LARGEST_SCALE_PX = 3.5
"""The widest of the kernels: what is to be hidden from the marks is hidden at its width."""

_SCALES_PX = (1.0, 2.0, LARGEST_SCALE_PX)
_SHARE_OF_SPREAD = 0.5


def spread_over_scales(
    picture: Picture,
    patches: Patches,
    fit: PatchFit,
    evaluate: Evaluate,
    blur: int,
    prior: Prior | None = None,
) -> FloatArray:
    """Return the standard deviation of the centre over Gaussian kernels, shape (N, 2), px.

    From the fit one step is taken in the picture as it is, and smoothed by each kernel. All
    look at the same pixels: with others hidden the centre would move by noise alone.

    Parameters
    ----------
    picture
        Shape (H, W).
    patches
        The windows, with what the widest kernel smears hidden.
    fit, evaluate, prior
        The fit, its model and what was known besides.
    blur
        The place of the parameter that a kernel widens.
    """
    prior = prior or Prior.nothing(fit.parameters.shape)
    part, corner = patches.cut_out(picture)
    still = Seen.of(patches, fit.parameters, evaluate).robust()
    moves = [still.step(prior, fit.parameters)[:, :2]]
    for scale in _SCALES_PX:
        start = fit.parameters.copy()
        start[:, blur] = np.hypot(start[:, blur], scale)
        samples = patches.of(smoothed(part.astype(np.float32), scale), corner)
        seen = Seen.of(replace(patches, samples=samples), start, evaluate).robust()
        moves.append(seen.step(prior, fit.parameters)[:, :2])
    return np.asarray(np.std(moves, axis=0))


def sigma_with_spread(sigma_px: FloatArray, spread_px: FloatArray) -> FloatArray:
    """Return a fit's sigma, or half of the spread over kernels where that is larger.

    In white noise the spread is 0.7 to 0.9 of a fit's sigma, for the kernels look at the same
    noise: it says something new only from twice the sigma on.
    """
    return np.asarray(np.maximum(sigma_px, _SHARE_OF_SPREAD * spread_px))
