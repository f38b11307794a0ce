"""Which ridge points lie on a common line across the board: the stripe, or what looks like it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.views import StripePoints

_DRAWS = 300
_START_TOLERANCE_PX = 4.0  # what distortion bends a line by across a target
_TOLERANCE_PX = 0.8
_TOLERANCE_SIGMAS = 5.0
_MOST_BENT = 0.008  # sag over length
_LARGEST_SIGMA_PX = 1.0
_ALIKE = 0.94  # cosine between a point's normal and its line's
_FEWEST_POINTS = 12
_BIN_PX = 16.0
_MOST_LINES = 4
_LEAST_EVIDENCE = 0.4  # of the best: glare on a brushed surface makes short lines
_WIDEST_FOOT = 4.0  # in widths of the stripe


@dataclass(frozen=True, slots=True, eq=False)
class StripeLine:
    """A slightly curved line through ridge points.

    Attributes
    ----------
    origin_px, direction
        Shape (2,): a point near its middle, and its unit direction.
    bend
        Shape (3,): offset across it is ``bend[0] + bend[1] s + bend[2] s²`` at s px along.
    member
        Shape (N,), index of its points.
    reach_px
        The first and the last of them, along.
    coverage
        Share of the line, between the two, that has points.
    width_px, peak
        Medians over its points.
    unevenness
        Spread of the width over the width.
    """

    origin_px: FloatArray
    direction: FloatArray
    bend: FloatArray
    member: IntArray
    reach_px: tuple[float, float]
    coverage: float
    width_px: float
    peak: float
    unevenness: float

    def across_px(self, points_px: FloatArray) -> FloatArray:
        """Return signed distances of points, shape (..., 2), from the line."""
        along, aside = _split(points_px - self.origin_px, self.direction)
        return aside - _bent(self.bend, along)

    def lights_up(
        self, points_px: FloatArray, level: FloatArray, blur_px: float = 0.0
    ) -> BoolArray:
        """Return which points it lights up by more than a level.

        Parameters
        ----------
        points_px
            Shape (N, K, 2).
        level
            Shape (N,), counts.
        blur_px
            Kernel that the picture is smoothed by.
        """
        width = float(np.hypot(self.width_px, blur_px))
        peak = self.peak * self.width_px / width
        widths = np.sqrt(2.0 * np.log(np.maximum(peak / np.maximum(level, 1.0), 1.5)))
        half = 1.0 + width * np.minimum(widths, _WIDEST_FOOT)
        return np.asarray(np.abs(self.across_px(points_px)) < half[:, None])

    @property
    def length_px(self) -> float:
        """From the first point to the last."""
        return self.reach_px[1] - self.reach_px[0]

    @property
    def evidence(self) -> float:
        """How much it looks like the laser's: long, without gaps, of even width."""
        return self.length_px * self.coverage / (1.0 + 2.0 * self.unevenness)


def lit_by(
    lines: Sequence[StripeLine], points_px: FloatArray, level: FloatArray, blur_px: float = 0.0
) -> BoolArray:
    """Return which points any of some lines lights up; as `StripeLine.lights_up`."""
    lit = np.zeros(points_px.shape[:2], dtype=bool)
    for line in lines:
        lit |= line.lights_up(points_px, level, blur_px)
    return lit


def find_lines(points: StripePoints, usable: BoolArray, least_length_px: float) -> list[StripeLine]:
    """Find the lines that ridge points make, the one with most evidence first.

    Parameters
    ----------
    points
        All ridge points.
    usable
        Shape (N,), those to look at.
    least_length_px
        Shorter lines are left out.
    """
    rng = np.random.default_rng(0)
    left = np.flatnonzero(usable & (points.sigma_px < _LARGEST_SIGMA_PX))
    lines: list[StripeLine] = []
    for _ in range(_MOST_LINES):
        line = _best_line(points, left, rng)
        if line is None:
            break
        if line.length_px >= least_length_px and line.coverage >= 0.3:
            lines.append(line)
        near = np.abs(line.across_px(points.centre_px[left])) < 2.0 * _START_TOLERANCE_PX
        left = left[~near]
    lines.sort(key=lambda line: -line.evidence)
    return [line for line in lines if line.evidence >= _LEAST_EVIDENCE * lines[0].evidence]


def _best_line(points: StripePoints, left: IntArray, rng: np.random.Generator) -> StripeLine | None:
    """Return the line with most points among those left, drawn by pairs and then refined."""
    if left.size < _FEWEST_POINTS:
        return None
    place, normal = points.centre_px[left], points.normal[left]
    one, other = rng.integers(0, left.size, (2, _DRAWS))
    apart = place[other] - place[one]
    length = np.linalg.norm(apart, axis=1)
    far = length > 30.0
    if not far.any():
        return None
    apart, one = apart[far] / length[far, None], one[far]
    across = np.column_stack([-apart[:, 1], apart[:, 0]])
    offset = np.abs(place @ across.T - (place[one] * across).sum(axis=1))
    agrees = (offset < _START_TOLERANCE_PX) & (np.abs(normal @ across.T) > _ALIKE)
    best = int(agrees.sum(axis=0).argmax())
    if agrees[:, best].sum() < _FEWEST_POINTS:
        return None
    return _refined(points, left, place[agrees[:, best]].mean(axis=0), apart[best])


def _refined(
    points: StripePoints, left: IntArray, origin: FloatArray, direction: FloatArray
) -> StripeLine | None:
    """Fit a parabola to the points near a line, robustly."""
    along, aside = _split(points.centre_px[left] - origin, direction)
    sigma = points.sigma_px[left]
    near = np.abs(aside) < _START_TOLERANCE_PX
    if near.sum() < _FEWEST_POINTS:
        return None
    bend = np.array([float(np.median(aside[near])), 0.0, 0.0])
    reach = max(float(np.ptp(along[near])), 1.0)
    for tolerance in (4.0, 2.0, 1.5, 1.0, 1.0, 1.0):
        off = aside - _bent(bend, along)
        limit = np.maximum(_TOLERANCE_PX, _TOLERANCE_SIGMAS * np.minimum(sigma, 0.5)) * tolerance
        near = np.abs(off) < limit
        if near.sum() < _FEWEST_POINTS:
            return None
        bend = _parabola(along[near] / reach, aside[near], np.maximum(sigma[near], 0.05), reach)
        bend = bend / np.array([1.0, reach, reach**2])
    straight = np.abs(points.normal[left] @ np.array([-direction[1], direction[0]])) > _ALIKE
    near &= straight
    if near.sum() < _FEWEST_POINTS:
        return None
    return _described(points, left[near], along[near], (origin, direction, bend))


def _parabola(along: FloatArray, aside: FloatArray, sigma: FloatArray, reach: float) -> FloatArray:
    """Fit robustly; `along` is in units of `reach`, px.

    What bends more than a lens bends a line is a line with foreign points at an end.
    """
    bend = _curve(along, aside, sigma, degree=2)
    if abs(bend[2]) > 4.0 * _MOST_BENT * reach:
        bend = np.append(_curve(along, aside, sigma, degree=1), 0.0)
    return bend


def _curve(along: FloatArray, aside: FloatArray, sigma: FloatArray, degree: int) -> FloatArray:
    """Fit a polynomial by reweighting."""
    design = along[:, None] ** np.arange(degree + 1)
    weight = 1.0 / sigma
    for _ in range(4):
        bend = np.linalg.lstsq(design * weight[:, None], aside * weight)[0]
        off = (aside - design @ bend) / sigma
        scale = max(float(np.median(np.abs(off))) / 0.6745, 0.5)
        weight = 1.0 / sigma / (1.0 + (off / (2.0 * scale)) ** 2)
    return np.asarray(bend)


def _described(
    points: StripePoints,
    member: IntArray,
    along: FloatArray,
    shape: tuple[FloatArray, FloatArray, FloatArray],
) -> StripeLine:
    bins = np.floor(along / _BIN_PX)
    width = points.width_px[member]
    middle = float(np.median(width))
    return StripeLine(
        *shape,
        member=member,
        reach_px=(float(along.min()), float(along.max())),
        coverage=float(np.unique(bins).size / (bins.max() - bins.min() + 1.0)),
        width_px=middle,
        peak=float(np.median(points.peak[member])),
        unevenness=float(np.median(np.abs(width - middle)) / middle),
    )


def _split(offset: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the parts along and across a direction."""
    along = offset @ direction
    return along, offset @ np.array([-direction[1], direction[0]])


def _bent(bend: FloatArray, along: FloatArray) -> FloatArray:
    return np.asarray(bend[0] + along * (bend[1] + along * bend[2]))
