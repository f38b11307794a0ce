"""A measured profile as a curve of points that can be read anywhere along it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray
from measure.gauging.estimate import Estimate
from measure.gauging.localfit import LocalFit
from measure.quantities import Status

_BIN_MM = 0.5
# Farther from the nearest point than this a value is extrapolated, or bridges a gap; farther than
# the other it is none.
_NEAR_MM = 0.8
_EXTRAPOLATION_MM = 2.0
# Beyond the points the profile may bend otherwise than the parabola, by 1 / 13 mm at the throat.
_BEND_BEYOND = 0.04
_FALLBACK_GAP = 1.2
_REFITS = 6
_SETTLED_MM = 0.2
# A wide window is used where it agrees with a narrow one to this many of the narrow one's sigmas.
_AGREEMENT_SIGMAS = 3.0


@dataclass(frozen=True, slots=True)
class Found:
    """An estimate, how it was come by, and the sigma of what no point tells (extrapolation)."""

    estimate: Estimate
    status: Status
    blind_mm: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Points of a profile, in order from the flange back to the field side.

    Attributes
    ----------
    points_mm
        Shape (N, 2): lateral place a (rising to the field side) and height r (rising outward).
    along_mm
        Shape (N,), rising: place along the profile.
    sigma_mm
        Shape (N,): standard deviation across the profile, as it counts in a mean.
    window_mm
        Half-width of the pieces that are smoothed.
    """

    points_mm: FloatArray
    along_mm: FloatArray
    sigma_mm: FloatArray
    window_mm: float

    def __len__(self) -> int:
        return len(self.points_mm)

    def nodes(self) -> FloatArray:
        """Return means over half a millimetre of the profile, shape (M, 2)."""
        return _bin_means(self.points_mm, self.along_mm, 1.0 / self.sigma_mm**2)[0]

    def nodes_sigma(self) -> tuple[FloatArray, FloatArray]:
        """Return the nodes and their standard deviation, shapes (M, 2) and (M,)."""
        return _bin_means(self.points_mm, self.along_mm, 1.0 / self.sigma_mm**2)

    def nodes_seen_by(self, bits: IntArray) -> IntArray:
        """Return which bits, shape (N,) of the points, occur in each node, shape (M,)."""
        bins = _bins(self.along_mm)
        starts = np.flatnonzero(np.diff(bins, prepend=-1))
        return np.bitwise_or.reduceat(bits, starts)

    def fit(self, place_mm: FloatArray, scale: float = 1.0) -> LocalFit | None:
        """Fit the piece around a place; the window halves where the profile bends too sharply.

        Lepski's rule: the wide window is taken only where it agrees with the narrow one within
        the noise of the latter, so that a worn edge is followed and a smooth tread is averaged.
        """
        weight = 1.0 / self.sigma_mm**2
        half_window = self.window_mm * scale
        wide = LocalFit.around(self.points_mm, weight, place_mm, half_window)
        narrow = LocalFit.around(self.points_mm, weight, place_mm, half_window / 2.0)
        if wide is None:
            # Where points are sparse a wider window finds enough; a gap it must not bridge.
            wider = LocalFit.around(self.points_mm, weight, place_mm, 2.0 * half_window)
            bridges = wider is not None and wider.widest_gap_mm() > _FALLBACK_GAP * half_window
            return None if bridges else wider
        if narrow is None:
            return wide
        middle = narrow.point(0.0)
        gap = abs(wide.distance_mm(middle))
        sigma = float(np.sqrt(narrow.solver[0] ** 2 @ self.sigma_mm[narrow.index] ** 2))
        return wide if gap <= _AGREEMENT_SIGMAS * sigma else narrow

    def read(
        self, axis: int, level: Estimate, place_mm: FloatArray, scale: float = 1.0
    ) -> Found | None:
        """Read coordinate `axis` (0: a, 1: r) where the other one takes a value.

        Parameters
        ----------
        axis
            The coordinate to read.
        level
            The value of the other one, with its own gradient.
        place_mm
            Shape (2,), where to start looking.
        scale
            Factor on the window.

        Returns
        -------
        Found or None
            None where the points do not reach the place.
        """
        settled = self._settle(
            place_mm, scale, lambda fit: fit.crossing(1 - axis, level.value), _EXTRAPOLATION_MM
        )
        if settled is None:
            return None
        fit, s = settled
        read = fit.read(axis, s)
        moved = Estimate(read.value, read.gradient + fit.slope(axis, s) * level.gradient)
        away = fit.away_mm(s)
        if fit.covers(s) and away <= _NEAR_MM:
            return Found(moved, Status.OK)
        return Found(moved, Status.EXTRAPOLATED, _BEND_BEYOND * away**2 * abs(fit.gain(axis, s)))

    def crest(self, place_mm: FloatArray) -> Found | None:
        """Read the greatest r near a place; None where there is no crest between the points."""
        for scale in (1.0, 2.0):
            settled = self._settle(place_mm, scale, LocalFit.crest, _NEAR_MM)
            if settled is not None and settled[0].covers(settled[1]):
                fit, s = settled
                return Found(fit.read(1, s), Status.OK)
        return None

    def _settle(
        self,
        place_mm: FloatArray,
        scale: float,
        where: Callable[[LocalFit], float | None],
        reach_mm: float,
    ) -> tuple[LocalFit, float] | None:
        """Fit again around what is looked for, until it stays; None where the points end before.

        Beside a gap or an end the middle of a fit never gets there: the last good one serves.
        """
        settled = None
        for _ in range(_REFITS):
            fit = self.fit(place_mm, scale)
            s = where(fit) if fit is not None else None
            if fit is None or s is None or fit.away_mm(s) > reach_mm:
                break
            settled = fit, s
            before, place_mm = place_mm, fit.point(s)
            if np.linalg.norm(place_mm - before) < _SETTLED_MM:
                break
        return settled


def _bin_means(
    points_mm: FloatArray, along_mm: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    bins = _bins(along_mm)
    total = np.bincount(bins, weight)
    mean = [np.bincount(bins, weight * column) / total for column in points_mm.T]
    return np.column_stack(mean), 1.0 / np.sqrt(total)


def _bins(along_mm: FloatArray) -> IntArray:
    """Return the number of the bin of each point, without gaps, shape (N,)."""
    place = np.floor((along_mm - along_mm[0]) / _BIN_MM).astype(np.int64)
    return np.asarray(np.unique(place, return_inverse=True)[1])
