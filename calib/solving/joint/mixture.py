r"""Which points to believe, told from the data's own scatter.

Each kind of point (dots, stripe) is a mixture: a share :math:`1 - \pi` scatters normally with s
times its predicted sigma, the rest lies anywhere within `_REACH` of those standard deviations.
Share and scale are estimated with the answer (expectation maximisation), so clean data keep
practically all their weight - a point at 3 sigma counts for more than 0.98 - and gross errors
keep none. A fixed robust loss would cost 5 % of the information where there is nothing to reject.

Far from the answer the residuals are misfit, not noise. There the weights are Huber's, with the
scale from the median, which no start can lock out. They suit a camera's first solve, from dots
alone. With a stripe they do not: its many false points would together pull a pose off its dots.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray

# Half-width, in standard deviations, of the box an outlier may lie in.
_REACH = 50.0
_LEAST_SHARE, _FIRST_SHARE, _MOST_SHARE = 1e-3, 0.05, 0.5
# Half the square of a residual that is no longer told from a larger one: exp(710) overflows.
_LARGEST_EXPONENT = 300.0
# No point of a picture is believed more exactly than this, even in data without noise: beside
# points of half a pixel, weights a million times theirs would drown them in rounding.
_LEAST_SIGMA_PX = 1e-3
# A view none of whose points are believed must still have a pose, if a poor one.
_LEAST_WEIGHT = 1e-8
# Huber's turn from square to straight, in standard deviations.
_HUBER = 1.5
# Median of the squared length of a standard normal vector of 1 and 2 dimensions.
_MEDIAN_SQUARE = {1: 0.454936, 2: 1.386294}


@dataclass(frozen=True, slots=True)
class Mixture:
    """Scatter of one kind of point.

    Attributes
    ----------
    scale
        s: actual over predicted standard deviation of the points believed.
    share
        pi: share of outliers.
    settled
        False while the state is far from the answer (see the module's text).
    least_scale
        What `scale` does not fall below.
    correlated
        How many neighbouring points carry the information of one.
    """

    scale: float
    share: float
    settled: bool
    least_scale: float
    correlated: float = 1.0

    @property
    def variance(self) -> float:
        """Of a residual, with what its neighbours repeat counted once."""
        return self.scale**2 * self.correlated

    @classmethod
    def from_median(cls, residual: FloatArray, sigma_px: FloatArray) -> "Mixture":
        """Judge the scatter of whitened residuals, shape (N, 1 or 2), by their median."""
        if len(residual) == 0:
            return cls(1.0, _LEAST_SHARE, settled=False, least_scale=1.0)
        least = _LEAST_SIGMA_PX / float(np.median(sigma_px))
        square = float(np.median((residual**2).sum(axis=1)))
        scale = np.sqrt(square / _MEDIAN_SQUARE[residual.shape[1]])
        return cls(max(float(scale), least), _FIRST_SHARE, settled=False, least_scale=least)

    def weights(self, residual: FloatArray) -> FloatArray:
        """Return how far each point is believed, 0 to 1, shape (N,).

        Parameters
        ----------
        residual
            Shape (N, 1 or 2), over the predicted sigma.
        """
        square = np.einsum("ij,ij->i", residual, residual) / self.scale**2
        if not self.settled:
            return np.asarray(_HUBER / np.sqrt(square).clip(min=_HUBER))
        odds = self._odds(square, residual.shape[1])
        return np.asarray(np.maximum(1.0 / (1.0 + odds), _LEAST_WEIGHT))

    def surprise(self, residual: FloatArray) -> FloatArray:
        """Return minus twice the log likelihood of each point, over that of one without residual.

        For good points the square over the variance, for outliers a constant; shape (N,).
        """
        square = np.einsum("ij,ij->i", residual, residual) / self.scale**2
        square = np.minimum(square, 2.0 * _LARGEST_EXPONENT)
        odds = self._odds(square, residual.shape[1])
        return np.asarray(square - 2.0 * np.log1p(odds))

    def _odds(self, square: FloatArray, dimensions: int) -> FloatArray:
        """Return how much likelier points of such squares are outliers than good, shape (N,)."""
        normal = (1.0 - self.share) * (2.0 * np.pi) ** (-dimensions / 2.0)
        box = self.share * (2.0 * _REACH) ** -dimensions
        return np.asarray(box / normal * np.exp(np.minimum(square / 2.0, _LARGEST_EXPONENT)))

    def believed(self, residual: FloatArray) -> BoolArray:
        """Tell which points are more likely good than not, shape (N,)."""
        return self.weights(residual) > 0.5

    def updated(self, residual: FloatArray, weights: FloatArray, spent: float) -> "Mixture":
        """Return the mixture these residuals speak for.

        Parameters
        ----------
        residual, weights
            Shape (N, 1 or 2) and (N,), the weights from `weights`.
        spent
            Degrees of freedom the parameters take from this kind of point.
        """
        freedom = weights.sum() * residual.shape[1] - spent
        if not freedom >= 1.0:
            return replace(self, settled=True)
        scale = np.sqrt((weights[:, None] * residual**2).sum() / freedom)
        share = np.clip(1.0 - weights.mean(), _LEAST_SHARE, _MOST_SHARE)
        return replace(
            self, scale=max(float(scale), self.least_scale), share=float(share), settled=True
        )


def correlated_run(
    residual: FloatArray, weights: FloatArray, group: IntArray, along: FloatArray
) -> float:
    """Return how many neighbours carry the information of one, from how alike their residuals are.

    Parameters
    ----------
    residual, weights
        Shape (N,).
    group, along
        Shape (N,), the group of each point and its place along it; points of different groups are
        independent.

    Returns
    -------
    float
        1 for independent points, else the sum of the correlations over all lags [1]_, taken up to
        the first lag whose correlation is within two standard deviations of zero.

    Notes
    -----
    The smoothing kernel of a ridge detector, speckle, and a sheet that is not quite flat all make
    neighbours alike. Counted as independent they would promise too small an uncertainty.

    References
    ----------
    .. [1] C. J. Geyer, "Practical Markov chain Monte Carlo", Statistical Science 7(4), 1992.
    """
    order = np.lexsort((along, group))
    value, group = (residual * weights)[order], group[order]
    variance = float(value @ value)
    if not variance > 0.0:
        return 1.0
    total = 1.0
    for lag in range(1, len(value) // 4):
        same = group[lag:] == group[:-lag]
        pairs = max(int(np.count_nonzero(same)), 1)
        correlation = float(value[lag:] @ (value[:-lag] * same)) / variance
        if not correlation > 2.0 / np.sqrt(pairs):
            break
        total += 2.0 * correlation
    return total
