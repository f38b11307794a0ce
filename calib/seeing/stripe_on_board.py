"""The stripe across the board: the right line of ridge points, free of the target's own marks."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.homography import apply_homography
from calib.seeing.ellipse import Ellipses
from calib.seeing.noise import PixelNoise
from calib.seeing.stripe import kernel_of, locate_stripe
from calib.seeing.stripe_lines import StripeLine, find_lines
from calib.views import Cause, StripePoints

_NEAR_PITCHES = 1.1
"""How far beyond its outermost points a board surely reaches."""

_FAR_PITCHES = 4.0
_SHORTEST_PITCHES = 1.5
_CLEAR_OF_MARKS = 4.0  # widths of a stripe from a mark: farther, its light hardly pulls
_OFF_MARKS = 2.0  # nearer there is no ridge of the stripe's own
_LEFT_OF_CLEARED = 0.1  # of the contrast of dots taken off
_LASER_LEFT = 0.2  # of the stripe's: what a dot returns of it is known the least
_PULL = float(np.sqrt(2.0 / np.pi))
_MARKS_AND_GROUND = (5.0, 95.0)  # percentiles of the board's brightness
_INDEPENDENT = 3.5  # kernels between two points whose errors are independent
_FEWEST_POINTS = 6
_FEWEST_TO_JUDGE = 12
_SCATTER_NOTED = 1.15
_FARTHEST_OFF = 4.0  # sigmas from the line


@dataclass(frozen=True, slots=True, eq=False)
class BoardArea:
    """Where the target's points are in the picture, in coordinates of its lattice.

    Attributes
    ----------
    picture_from_node
        Shape (3, 3).
    low, high
        Shape (2,), the outermost nodes.
    dots
        Outlines of the dots; None for a chessboard.
    cleared
        The dots are taken off the picture: what is left of them draws a stripe little.
    """

    picture_from_node: FloatArray
    low: IntArray
    high: IntArray
    dots: Ellipses | None
    cleared: bool = False

    @property
    def off_marks_widths(self) -> float:
        """How many of its widths from a mark a stripe's point has to be."""
        return 0.0 if self.cleared else _OFF_MARKS

    @property
    def pitch_px(self) -> float:
        """Distance of neighbours in the middle of the target."""
        middle = np.asarray(0.5 * (self.low + self.high), dtype=np.float64)
        beside = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        points = apply_homography(self.picture_from_node, middle + beside)
        return float(np.linalg.norm(points[1:] - points[0], axis=1).min())

    @property
    def side_px(self) -> float:
        """Length of the target's shorter side."""
        return float((self.high - self.low).min()) * self.pitch_px

    def region(self, shape: tuple[int, ...], margin_pitches: float) -> BoolArray:
        """Return the pixels on the board, `margin_pitches` beyond its outermost points."""
        (a, b), (c, d) = self.low - margin_pitches, self.high + margin_pitches
        corners = apply_homography(
            self.picture_from_node, np.array([[a, b], [c, b], [c, d], [a, d]], dtype=np.float64)
        )
        mask = np.zeros(shape[:2], dtype=np.uint8)
        cv2.fillConvexPoly(mask, np.rint(np.clip(corners, -20000, 20000)).astype(np.int32), 1)
        return mask.astype(bool)

    def clearance_px(self, points_px: FloatArray) -> FloatArray:
        """Return how far points, shape (N, 2), are from a dot's outline or a square's edge, (N,).

        Negative inside a dot; a pixel is left for what the outlines are not known to.
        """
        if self.dots is not None:
            return _beyond_dots_px(self.dots, points_px) - 1.0
        node_from_picture = np.asarray(np.linalg.inv(self.picture_from_node), dtype=np.float64)
        node = apply_homography(node_from_picture, points_px)
        gap = np.abs(node - np.rint(node)).min(axis=1) * self.pitch_px
        inside = ((node > self.low - 1.2) & (node < self.high + 1.2)).all(axis=1)
        return np.where(inside, gap - 1.0, np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class BoardStripes:
    """Ridge points on and around the board, and the lines they make, the likeliest first.

    Attributes
    ----------
    points
        All ridge points.
    lines
        Their lines; `member` counts in `points`.
    off_board
        The lines were found only beyond what surely is the board.
    contrast
        Counts between the board's marks and its ground.
    """

    points: StripePoints
    lines: list[StripeLine]
    off_board: bool
    contrast: float


def find_board_stripes(picture: Picture, noise: PixelNoise, area: BoardArea) -> BoardStripes:
    """Find every line across the board that might be the stripe.

    A printed board may be larger than its pattern: where no line of some length crosses the
    pattern, lines around it are looked at as well.
    """
    near = _stripes_within(picture, noise, area, _NEAR_PITCHES)
    if near.lines and near.lines[0].length_px >= 0.5 * area.side_px:
        return near
    far = _stripes_within(picture, noise, area, _FAR_PITCHES)
    if not far.lines or (near.lines and near.lines[0].evidence > 0.5 * far.lines[0].evidence):
        return near
    return far


def _stripes_within(
    picture: Picture, noise: PixelNoise, area: BoardArea, margin_pitches: float
) -> BoardStripes:
    region = area.region(picture.shape, margin_pitches)
    points = locate_stripe(picture, region=region, noise=noise)
    usable = area.clearance_px(points.centre_px) >= area.off_marks_widths * points.width_px
    lines = find_lines(points, usable, _SHORTEST_PITCHES * area.pitch_px)
    every = np.s_[::4, ::4]  # a sample is enough
    board = picture[every][area.region(picture.shape, 0.5)[every]]
    contrast = np.ptp(np.percentile(board, _MARKS_AND_GROUND)) if board.size else 0.0
    contrast *= _LEFT_OF_CLEARED if area.cleared else 1.0
    return BoardStripes(points, lines, margin_pitches > _NEAR_PITCHES, float(contrast))


def stripes_of_board(found: BoardStripes, area: BoardArea) -> list[StripePoints]:
    """Return the points of each line, the likeliest first, thinned until errors are independent.

    Parameters
    ----------
    found
        The lines.
    area
        The board, all its marks known by now.

    Returns
    -------
    stripes
        Without lines of which too few points are left. Sigma is raised by what the light of a
        mark nearby may draw a point, and where the points scatter by more than it says: by speckle
        or the surface's grain. A stripe that hardly is clear of the target's marks is
        `Cause.CROSSED`.
    """
    stripes = (_stripe_on(line, found, area) for line in found.lines)
    return [stripe for stripe in stripes if stripe is not None]


def _stripe_on(line: StripeLine, found: BoardStripes, area: BoardArea) -> StripePoints | None:
    points = found.points.select(line.member)
    clearance = area.clearance_px(points.centre_px) / points.width_px
    off_marks = clearance >= area.off_marks_widths
    points, clearance = points.select(off_marks), clearance[off_marks]
    pull = _pull_px(points, area, found.contrast)
    chosen = _independent(points, line, pull)
    points = replace(points, sigma_px=np.hypot(points.sigma_px, pull))
    points, clearance = points.select(chosen), clearance[chosen]
    if len(points) < _FEWEST_POINTS:
        return None
    crossed = not area.cleared and np.count_nonzero(clearance >= _CLEAR_OF_MARKS) < _FEWEST_POINTS
    doubt = Cause.CROSSED if crossed else Cause.OFF_BOARD if found.off_board else None
    return _with_true_sigma(points, line, doubt)


def _pull_px(points: StripePoints, area: BoardArea, contrast: float) -> FloatArray:
    r"""Return how far the light of the nearest mark may draw each point, shape (N,).

    Notes
    -----
    A step of A counts, blurred as the stripe is, leaves at a distance of D, under the kernel
    :math:`\sigma_g = \sigma_w`, the gradient :math:`A e^{-D^2/4w^2} / \sqrt{4\pi} w`. Over the
    curvature of Eq. 8, :math:`M / 2^{3/2} w^2`, that is a shift by
    :math:`0.80\, w\, (A/M)\, e^{-D^2/4w^2}`: 0.3 w two widths away, 0.015 w four. Only its part
    across the stripe counts: a mark that the stripe runs into does not draw it aside.
    """
    width, normal = points.width_px, points.normal
    clearance = area.clearance_px(points.centre_px)
    after, before = (area.clearance_px(points.centre_px + side * normal) for side in (1.0, -1.0))
    with np.errstate(invalid="ignore"):  # far from every mark a clearance may be infinite
        aside = np.nan_to_num(np.minimum(0.5 * np.abs(after - before), 1.0))
    share = contrast / np.maximum(points.peak, 1.0) + (_LASER_LEFT if area.cleared else 0.0)
    fading = np.exp(-np.square(0.5 * clearance / width))
    return np.asarray(_PULL * width * share * aside * fading)


def _beyond_dots_px(dots: Ellipses, points_px: FloatArray) -> FloatArray:
    """Return how far points are outside the nearest dot's outline, shape (N,)."""
    offset = points_px[None] - dots.centre_px[:, None]
    return np.asarray(((dots.level(offset) - 1.0) * dots.radius_px[:, None]).min(axis=0))


def _independent(points: StripePoints, line: StripeLine, pull_px: FloatArray) -> IntArray:
    """Return the least drawn point of every stretch in which the kernel makes errors alike."""
    along = (points.centre_px - line.origin_px) @ line.direction
    if len(points) == 0:
        return np.zeros(0, dtype=np.int64)
    stretch = _INDEPENDENT * float(np.median(kernel_of(points.width_px)))
    number = np.floor(along / stretch)
    off_middle = np.abs(along / stretch - number - 0.5)
    # Not the one of least sigma, which is the one that promises too much; of points drawn alike,
    # to a tenth of the usual sigma, the one in the middle.
    drawn = np.rint(10.0 * pull_px / float(np.median(points.sigma_px)))
    order = np.lexsort((off_middle, drawn, number))
    first = np.concatenate([[True], np.diff(number[order]) > 0])
    return np.asarray(order[first], dtype=np.int64)


def _with_true_sigma(points: StripePoints, line: StripeLine, doubt: Cause | None) -> StripePoints:
    scale = 1.0
    off = line.across_px(points.centre_px) / points.sigma_px
    if len(points) >= _FEWEST_TO_JUDGE:
        scatter = float(np.median(np.abs(off - np.median(off)))) / 0.6745
        scale = scatter if scatter > _SCATTER_NOTED else 1.0
    points = points.select(np.abs(off) <= _FARTHEST_OFF * scale)
    cause = points.cause if doubt is None else (doubt,) * len(points)
    return replace(points, sigma_px=scale * points.sigma_px, cause=cause)
