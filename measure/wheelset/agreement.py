"""Which of several looks at one thing agree, and that none is believed where nothing tells."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from calib import FloatArray, IntArray

_SIGNIFICANCE = 0.01
"""In so many of all cases a look that is right is taken for wrong, and left out."""
_CLEARLY = 9.0
"""By so much more the sum of squares must fall without one look than without the next: of two
equally likely ones that are wrong, odds of a hundred to one."""
_LEAST_CHECKED = 1e-3
"""A residual that shows less than this share of an error shows none."""


@dataclass(frozen=True, slots=True, eq=False)
class Residuals:
    """What is left of observations after a fit.

    Attributes
    ----------
    residual_mm
        Shape (N,).
    covariance
        Shape (N, N), of the observations before the fit, mm².
    fitted
        Shape (N, N), of what the fit says of them, mm².
    look
        Shape (N,): which look each observation is of, from 0 without gaps.
    """

    residual_mm: FloatArray
    covariance: FloatArray
    fitted: FloatArray
    look: IntArray

    def suspicions(self) -> tuple[FloatArray, IntArray]:
        r"""Return by how much the sum of squares falls without each look, and its freedom.

        Returns
        -------
        falls, freedoms
            Shape (M,) each.

        Notes
        -----
        With C the covariance, F the fitted one, :math:`v = C^{-1} r` and
        :math:`Q = C^{-1} (C - F) C^{-1}`, leaving out the observations i takes
        :math:`v_i^T Q_{ii}^+ v_i` from the sum of squares [1]_: no fit is done again.

        References
        ----------
        .. [1] W. Baarda, "A testing procedure for use in geodetic networks", Netherlands Geodetic
           Commission, 1968.
        """
        inverse = np.linalg.inv(self.covariance)
        pull = inverse @ self.residual_mm
        open_to_error = inverse - inverse @ self.fitted @ inverse
        falls, freedoms = [], []
        for look in range(int(self.look.max()) + 1):
            mine = np.flatnonzero(self.look == look)
            root = np.linalg.cholesky(self.covariance[np.ix_(mine, mine)])
            share, axes = np.linalg.eigh(root.T @ open_to_error[np.ix_(mine, mine)] @ root)
            checked = share > _LEAST_CHECKED
            along = (axes.T @ (root.T @ pull[mine]))[checked]
            falls.append(float(np.sum(along**2 / share[checked])))
            freedoms.append(int(checked.sum()))
        return np.array(falls), np.array(freedoms, dtype=np.int64)


def agreeing(
    count: int, residuals_of: Callable[[IntArray], Residuals | None], *, fewest: int
) -> IntArray | None:
    """Return which looks agree, more than half of all; None where that is not told.

    Parameters
    ----------
    count
        How many there are.
    residuals_of
        Of a fit to some of them, by their numbers; None where it fails.
    fewest
        So many must be left.

    Notes
    -----
    Looks are left out one by one, each time the one without which the others agree best. Where
    another may as well be the one that is wrong, none is left out: the answer is None.
    """
    kept = np.arange(count)
    while True:
        residuals = residuals_of(kept)
        if residuals is None:
            return None
        falls, freedoms = residuals.suspicions()
        worst = int(np.argmax(falls))
        chance = float(chdtrc(max(int(freedoms[worst]), 1), falls[worst]))
        if chance * len(kept) > _SIGNIFICANCE:
            return kept
        told = falls[worst] - np.delete(falls, worst).max(initial=0.0) > _CLEARLY
        if not told or len(kept) - 1 < max(fewest, count // 2 + 1):
            return None
        kept = np.delete(kept, worst)
