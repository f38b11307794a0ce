"""Whether what a fit leaves over is noise, pixel by pixel, or hangs together."""

import numpy as np

from calib.arrays import FloatArray, IntArray

_SQUARE_PX = 6


def coherence_of(
    residual: FloatArray,
    weight: FloatArray,
    jacobian: FloatArray,
    inverse: FloatArray,
    offset: IntArray,
) -> FloatArray:
    r"""Return how much more what is left over pulls at the centres than white noise would.

    Parameters
    ----------
    residual, weight
        Shape (N, K); the weight of a pixel not used is 0, else 1 / variance.
    jacobian
        Shape (N, P, K).
    inverse
        Shape (N, P, P), of the normal matrix. The first two parameters are the centre.
    offset
        Shape (K, 2), the pixels' places in whole pixels, in the order of `in_squares`.

    Returns
    -------
    coherence
        Shape (N,), a ratio of variances: 1 on average in white noise of the given variance.

    Notes
    -----
    Texture, a reflection's border or a model a little wrong leave residuals that agree with
    their neighbours, and a covariance that takes pixels as independent is too small. The pull
    of all the pixels of a square of 6 x 6 together is squared, the squares' sum compared with
    what white noise would give [1]_. With B the pixels' lever on the centre, J their derivatives
    and N the normal matrix, a fit leaves of a square's variance :math:`\sum w B^2` only
    :math:`\sum w B^2 - g^T N^{-1} g`, :math:`g = \sum w B J`: it takes out what it can explain
    [2]_. What hangs together over more than a square is counted in part.

    References
    ----------
    .. [1] K.-Y. Liang and S. L. Zeger, "Longitudinal data analysis using generalized linear
       models", Biometrika 73(1), 1986.
    .. [2] R. M. Bell and D. F. McCaffrey, "Bias reduction in standard errors for linear
       regression with multi-stage samples", Survey Methodology 28(2), 2002.
    """
    start = np.flatnonzero(np.diff(_square(offset), prepend=-1))
    lever = inverse[:, :2].astype(jacobian.dtype) @ jacobian
    pulled = lever * weight[:, None]
    together = np.add.reduceat(pulled * residual[:, None], start, axis=2)
    alone = (lever * pulled).sum(axis=2)
    # One parameter at a time keeps the working memory small.
    shared = np.stack(
        [
            np.add.reduceat(pulled * jacobian[:, i, None], start, axis=2)
            for i in range(jacobian.shape[1])
        ],
        axis=2,
    ).astype(np.float64)
    explained = (shared * (inverse[:, None] @ shared)).sum(axis=(2, 3))
    left = np.maximum(alone - explained, 1e-3 * alone + 1e-30)
    return np.asarray(((together**2).sum(axis=2) / left).mean(axis=1), dtype=np.float64)


def in_squares(offset: IntArray) -> IntArray:
    """Return places, shape (K, 2), in the order that puts each square's pixels together."""
    return np.asarray(offset[np.argsort(_square(offset), kind="stable")])


def _square(offset: IntArray) -> IntArray:
    """Return a number for the square that each place lies in, shape (K,)."""
    u, v = (offset // _SQUARE_PX - (offset // _SQUARE_PX).min(axis=0)).T
    return np.asarray(v * (u.max() + 1) + u)
