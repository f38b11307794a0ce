"""The inner corners of a chessboard in one picture: found, numbered, measured."""

from dataclasses import dataclass

import cv2
import numpy as np

from calib import saddle
from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.grid import (
    Lattice,
    agreeing,
    apply_homography,
    find_lattice,
    inside_target,
    number,
)
from calib.noise import PixelNoise
from calib.patch_fit import SCALES_PX, Patches, fit_patches, spread_over_scales
from calib.seen import SeenTarget
from calib.stripe_lines import StripeLine, lit_by
from calib.stripe_on_board import BoardArea
from calib.target import Target
from calib.views import Cause

_LARGEST_SIDE_PX = 1100
_KERNEL_PX = 2.0
_MOST_CORNERS = 600
_RING_PX = 5.0
_RING_POINTS = 32
_ALIKE_ACROSS = 0.55
_PATCH_PITCHES, _LARGEST_PATCH_PX, _SMALLEST_PATCH_PX = 0.38, 11.0, 3.5
_START_BLUR_PX = 1.2
_STRIPE_FOOT = 0.06
_CROSSED_FROM, _CLIPPED_FROM = 0.02, 0.05
_FAINTEST = 0.2


@dataclass(frozen=True, slots=True, eq=False)
class CornerPattern:
    """Corners on a common lattice, not yet numbered."""

    lattice: Lattice

    def __len__(self) -> int:
        return len(self.lattice)

    @classmethod
    def find(cls, picture: Picture, noise: PixelNoise, target: Target) -> "CornerPattern | None":
        """Find the inner corners of a chessboard; None where none make a lattice."""
        corners = find_corners(picture, noise)
        lattice = find_lattice(corners, np.ones(len(corners)), target.rows * target.cols)
        return None if lattice is None else cls(lattice)

    def area(self, target: Target) -> BoardArea:
        """Return where the target may be in the picture."""
        low, high = self.lattice.extent(target.rows, target.cols)
        return BoardArea(self.lattice.picture_from_node, low, high, None)

    def numbered(
        self, picture: Picture, noise: PixelNoise, target: Target, lines: list[StripeLine]
    ) -> SeenTarget | None:
        """Measure the corners, those that the lattice predicts as well, and number them.

        Parameters
        ----------
        picture, noise, target
            As the corners were found with.
        lines
            Stripes across the board.

        Returns
        -------
        SeenTarget or None
            None where the numbering is not certain.
        """
        mine, empty = self.lattice.within_target(target.rows, target.cols)
        node = np.concatenate([self.lattice.node[mine], empty])
        corners = measure_corners(picture, noise, self.lattice, node, lines)
        keep = corners.trusted
        numbering = number(node[keep], self.lattice.picture_from_node, target.rows, target.cols)
        if numbering is None:
            return None
        place = numbering.rows_and_cols(node)
        keep = keep & inside_target(place, target.rows, target.cols)
        homography, agree = agreeing(place[keep], corners.centre_px[keep], corners.sigma_px[keep])
        index = np.flatnonzero(keep)[agree]
        return SeenTarget(
            place[index],
            corners.centre_px[index],
            corners.sigma_px[index],
            tuple(corners.cause[i] for i in index),
            homography,
            None,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """What was measured of N corners: centre and sigma, (N, 2), what is doubtful, what to trust."""

    centre_px: FloatArray
    sigma_px: FloatArray
    cause: tuple[Cause, ...]
    trusted: BoolArray


def find_corners(picture: Picture, noise: PixelNoise) -> FloatArray:
    """Find saddle points of brightness where two squares of a kind touch, to about a pixel.

    Returns
    -------
    place_px
        Shape (N, 2), the strongest first.
    """
    shrink = max(1, int(np.ceil(max(picture.shape) / _LARGEST_SIDE_PX)))
    small = cv2.resize(
        picture,
        (picture.shape[1] // shrink, picture.shape[0] // shrink),
        interpolation=cv2.INTER_AREA,
    )
    smooth = cv2.GaussianBlur(small.astype(np.float32), (0, 0), _KERNEL_PX)
    guu = cv2.Sobel(smooth, cv2.CV_32F, 2, 0, ksize=3, scale=0.25)
    gvv = cv2.Sobel(smooth, cv2.CV_32F, 0, 2, ksize=3, scale=0.25)
    guv = cv2.Sobel(smooth, cv2.CV_32F, 1, 1, ksize=3, scale=0.25)
    # At a corner of contrast 2 a the mixed derivative is 0.64 a / s².
    square = guv**2 - guu * gvv
    least = 0.3 * max(3.0, 3.0 * float(np.sqrt(noise.floor)) / shrink) / _KERNEL_PX**2
    top = (square == cv2.dilate(square, np.ones((7, 7), dtype=np.uint8))) & (square > least**2)
    v, u = np.nonzero(top)
    strongest = np.argsort(-square[v, u], kind="stable")[:_MOST_CORNERS]
    place = np.column_stack([u, v])[strongest].astype(np.float64)
    place = place[_looks_like_squares(small, place)]
    return np.asarray(shrink * place + 0.5 * (shrink - 1))


def _looks_like_squares(small: Picture, place: FloatArray) -> BoolArray:
    """Return where a ring about a place is alike on opposite sides, and half of it bright."""
    if len(place) == 0:
        return np.zeros(0, dtype=bool)
    angle = np.arange(_RING_POINTS) * (2.0 * np.pi / _RING_POINTS)
    u = place[:, :1] + _RING_PX * np.cos(angle)
    v = place[:, 1:] + _RING_PX * np.sin(angle)
    ring = cv2.remap(
        small,
        u.astype(np.float32),
        v.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    ).astype(np.float64)
    ring -= ring.mean(axis=1, keepdims=True)
    power = np.maximum((ring**2).sum(axis=1), 1e-9)
    across = (ring * np.roll(ring, _RING_POINTS // 2, axis=1)).sum(axis=1) / power
    bright = (ring > 0.0).mean(axis=1)
    return np.asarray((across > _ALIKE_ACROSS) & (bright > 0.25) & (bright < 0.75))


def measure_corners(
    picture: Picture,
    noise: PixelNoise,
    lattice: Lattice,
    node: IntArray,
    lines: list[StripeLine],
) -> Corners:
    """Fit the picture of a corner at each node, shape (N, 2), of a lattice.

    Sigma is the larger of what noise and scatter give by the fit, and of the spread of the
    centre over Gaussian kernels. Pixels that a stripe lights up are not looked at.
    """
    centre = lattice.predict(node)
    # What is off the lattice is taken over from the corners that were found.
    edges = np.stack(
        [lattice.predict(node + np.array(s)) - centre for s in ((0, 1), (1, 0))], axis=1
    )
    pitch = float(np.median(np.linalg.norm(edges, axis=2).min(axis=1)))
    reach = float(np.clip(_PATCH_PITCHES * pitch, _SMALLEST_PATCH_PX, _LARGEST_PATCH_PX))
    origin = np.rint(centre).astype(np.int64)
    side = np.arange(-int(reach), int(reach) + 1)
    offset = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    offset = offset[np.hypot(*offset.T) <= reach]
    use = np.ones((len(node), len(offset)), dtype=bool)
    smooth = np.asarray(cv2.blur(picture, (3, 3)), dtype=np.uint8)
    patches = Patches.cut(picture, smooth, noise, origin, offset, use)
    contrast = 0.5 * np.ptp(np.percentile(patches.samples, [15, 85], axis=1), axis=0)
    place, foot = patches.places_px(), _STRIPE_FOOT * contrast
    band = lit_by(lines, place, foot)
    first = saddle.start(centre, origin, edges, _START_BLUR_PX)
    fit = fit_patches(patches.without(band), first, saddle.evaluate, saddle.sound)
    seen = [patches.without(lit_by(lines, place, foot, scale)) for scale in SCALES_PX]
    spread = spread_over_scales(picture, seen, fit, saddle.evaluate, saddle.BLUR)
    by_noise = fit.sigma_px
    hidden = band.mean(axis=1)
    clipped = patches.clipped.mean(axis=1)
    height = np.abs(fit.parameters[:, saddle.HEIGHT])
    moved = np.linalg.norm(fit.parameters[:, :2] - first[:, :2], axis=1)
    trusted = (
        (moved < 0.2 * pitch)
        & (height > np.maximum(_FAINTEST * np.median(height), 2.0))
        & (by_noise.max(axis=1) < 0.5)
        & (hidden < 0.6)
    )
    cause = tuple(
        Cause.CROSSED if h > _CROSSED_FROM else Cause.SATURATED if c > _CLIPPED_FROM else Cause.NONE
        for h, c in zip(hidden, clipped, strict=True)
    )
    return Corners(fit.parameters[:, :2] + origin, np.maximum(by_noise, spread), cause, trusted)
