"""A chessboard's picture without its black: what is left is the stripe, on all squares alike."""

import cv2
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.special import ndtr

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.homography import apply_homography
from calib.seeing.lattice import Lattice
from calib.seeing.resample import Float32Array

_BLURS_PX = (0.7, 1.0, 1.5, 2.2, 3.3)
_INNER = 0.3  # of a square, from its middle: clear of its edges
_DEGREE = 3  # of what a lens bends
_CORNERS_OF_A_SQUARE = 2
_EVERY_LINE = 7
_BLOCK_PX = 8
_EDGE_COUNTS = 30.0  # a steeper step is the stripe's or the board's border
_FAR_BLURS = 6.0


def without_black(picture: Picture, lattice: Lattice, place_px: FloatArray) -> Picture:
    """Lift the black squares of a chessboard to the brightness of the white ones beside them.

    Parameters
    ----------
    picture
        Shape (H, W).
    lattice
        Of the inner corners.
    place_px
        Shape (N, 2), where the lattice's points are seen.

    Returns
    -------
    picture
        Shape (H, W). The white squares are as they were, so that what is clipped stays clipped.
        A square is as bright as the median of its inner pixels, which a stripe does not move. The
        blur of the edges is the one, of five, that leaves least of them. The picture itself where
        no black and white square is seen.
    """
    low, high = lattice.node.min(axis=0) - 1, lattice.node.max(axis=0) + 1
    corner, size = _box(picture.shape, lattice, low, high)
    window = np.s_[corner[1] : corner[1] + size[1], corner[0] : corner[0] + size[0]]
    part = picture[window].astype(np.float32)
    node = _node_of_pixels(corner, size, lattice, place_px) - low
    inside = _on_seen_squares(node, lattice.node - low, high - low)
    bright = _brightness(part.ravel(), node, inside, high - low)
    row, col = np.indices(bright.shape)
    even = (row + col) % 2 == 0
    known = np.isfinite(bright)
    if not ((known & even).any() and (known & ~even).any()):
        return picture
    even_black = bool(np.nanmean(bright[even]) < np.nanmean(bright[~even]))
    # White beside white is not lifted: that is the rim of the pattern, where the paper begins.
    across = _on_seen_squares(_over_the_nearest_edge(node), lattice.node - low, high - low)
    own_black = (np.floor(node).sum(axis=1) % 2 == 0) == even_black
    lifts = _between_squares(_lift(bright, even == even_black), node)
    lift = np.where(inside & (own_black | across), lifts, 0.0)
    edge = (np.sin(np.pi * node) / np.pi * _steps_px(lattice)).astype(np.float32)
    flat = _flattened(
        part,
        lift.astype(np.float32).reshape(part.shape),
        edge.reshape(*part.shape, 2),
        1.0 if even_black else -1.0,
    )
    lifted = picture.copy()
    lifted[window] = np.clip(np.rint(flat), 0.0, 255.0)
    return lifted


def _flattened(
    part: Float32Array, lift: Float32Array, edge_px: Float32Array, sign: float
) -> Float32Array:
    """Return the part with its black lifted, with the blur that suits some of its lines best."""
    some = np.s_[::_EVERY_LINE]

    def roughness(blur: float) -> float:
        flat = part[some] + lift[some] * _blackness(sign, edge_px[some] / blur)
        return float(np.mean(np.minimum(np.abs(np.diff(flat, axis=1)), _EDGE_COUNTS)))

    best = min(_BLURS_PX, key=roughness)
    return np.asarray(part + lift * _blackness(sign, edge_px / best), dtype=np.float32)


def _box(
    shape: tuple[int, ...], lattice: Lattice, low: IntArray, high: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the corner and the size, (u, v), of the part of the picture that holds the squares."""
    corners = lattice.predict(
        np.array([[a, b] for a in (low[0], high[0]) for b in (low[1], high[1])])
    )
    limit = np.array([shape[1], shape[0]])
    first = np.clip(np.floor(corners.min(axis=0)), 0, limit - 2).astype(np.int64)
    last = np.clip(np.ceil(corners.max(axis=0)), first + 2, limit).astype(np.int64)
    return first, last - first


def _node_of_pixels(
    corner: IntArray, size: IntArray, lattice: Lattice, place_px: FloatArray
) -> FloatArray:
    """Return where on the lattice the pixels of a part of the picture lie, shape (N, 2).

    The map is smooth: it is found at the middles of blocks, one block beyond the part, and
    interpolated between.
    """
    blocks = -(-size // _BLOCK_PX) + 2
    v, u = np.mgrid[: blocks[1], : blocks[0]]
    middle = (np.column_stack([u.ravel(), v.ravel()]) - 0.5) * _BLOCK_PX - 0.5 + corner
    coarse = _nodes(middle, lattice, place_px).reshape(blocks[1], blocks[0], 2)
    fine = cv2.resize(coarse, tuple((_BLOCK_PX * blocks).tolist()), interpolation=cv2.INTER_LINEAR)
    part = fine[_BLOCK_PX : _BLOCK_PX + size[1], _BLOCK_PX : _BLOCK_PX + size[0]]
    return np.asarray(part.reshape(-1, 2), dtype=np.float64)


def _nodes(pixels_px: FloatArray, lattice: Lattice, place_px: FloatArray) -> FloatArray:
    """Return where on the lattice pixels lie, shape (N, 2): by its map, and by the lens's bend."""
    node_from_picture = np.asarray(np.linalg.inv(lattice.picture_from_node), dtype=np.float64)
    rough = apply_homography(node_from_picture, place_px)
    middle, scale = rough.mean(axis=0), np.ptp(rough, axis=0).max()
    degree = min(_DEGREE, int(np.sqrt(len(rough) / 2.0)) - 1)
    bend = np.linalg.lstsq(_powers((rough - middle) / scale, degree), lattice.node - rough)[0]
    node = apply_homography(node_from_picture, pixels_px)
    return np.asarray(node + _powers((node - middle) / scale, degree) @ bend)


def _powers(points: FloatArray, degree: int) -> FloatArray:
    x, y = points.T
    return np.stack([x**i * y**j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=1)


def _on_seen_squares(node: FloatArray, seen: IntArray, count: IntArray) -> BoolArray:
    """Return which places are on squares that have two seen corners or more.

    Beyond the board there is no black to lift, whatever a chance find there makes of the lattice.
    """
    corners = np.zeros(count + 2, dtype=np.int64)
    corners[tuple((seen + 1).T)] = 1
    square_has = corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]
    square = np.floor(node).astype(np.int64)
    within = ((square >= 0) & (square < count)).all(axis=1)
    first, second = np.clip(square, 0, count - 1).T + 1
    return np.asarray(within & (square_has[first, second] >= _CORNERS_OF_A_SQUARE))


def _over_the_nearest_edge(node: FloatArray) -> FloatArray:
    """Return places mirrored at the nearest edge of their square."""
    off = node - np.rint(node)
    nearest = np.abs(off) == np.abs(off).min(axis=1, keepdims=True)
    return np.asarray(node - 2.0 * off * nearest)


def _brightness(
    part: Float32Array, node: FloatArray, inside: BoolArray, count: IntArray
) -> FloatArray:
    """Return the median of each square's inner pixels, shape (R, C); NaN where it has none."""
    square = np.floor(node).astype(np.int64)
    inner = inside & (np.abs(node - square - 0.5) < _INNER).all(axis=1)
    number = (square[:, 0] * count[1] + square[:, 1])[inner]
    order = np.argsort(number, kind="stable")
    values, first = (
        part[inner][order],
        np.searchsorted(number[order], np.arange(np.prod(count) + 1)),
    )
    bright = [
        float(np.median(values[a:b])) if b > a else np.nan
        for a, b in zip(first[:-1], first[1:], strict=True)
    ]
    return np.array(bright).reshape(count)


def _lift(bright: FloatArray, black: BoolArray) -> FloatArray:
    """Return by how much black squares are darker than their neighbours; as much for those."""
    darker = _mean_beside(bright) - bright
    lift = np.where(black, darker, -darker)
    return np.where(lift > 0.0, lift, 0.0)


def _mean_beside(values: FloatArray) -> FloatArray:
    """Return the mean of those of the four neighbours that are known; NaN where none is."""
    cross = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    total, count = (
        cv2.filter2D(each, -1, cross, borderType=cv2.BORDER_CONSTANT)
        for each in (np.nan_to_num(values), np.isfinite(values).astype(np.float64))
    )
    return np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)


def _between_squares(values: FloatArray, node: FloatArray) -> FloatArray:
    """Interpolate what is known at the squares' middles, linearly."""
    at = np.clip(node - 0.5, 0.0, np.array(values.shape) - 1.0)
    return np.asarray(map_coordinates(values, at.T, order=1))


def _steps_px(lattice: Lattice) -> FloatArray:
    """Return the steps along both axes of the lattice in its middle, px, shape (2,)."""
    middle = lattice.node.mean(axis=0)
    points = lattice.predict(middle + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    return np.asarray(np.linalg.norm(points[1:] - points[0], axis=1))


def _blackness(sign: float, edge: Float32Array) -> Float32Array:
    """Return how black pixels are, 0 to 1, so many blurs from edges of both directions."""
    side = 2.0 * ndtr(np.clip(edge, -_FAR_BLURS, _FAR_BLURS)) - 1.0
    return np.asarray(0.5 + 0.5 * sign * side[..., 0] * side[..., 1], dtype=np.float32)
