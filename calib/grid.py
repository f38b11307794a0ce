"""Numbering: which of the points found are those of the target, and which is which."""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray

Node = tuple[int, int]

_NEAR_PREDICTION = 0.22  # of the step to a neighbour
_NEAR_HOMOGRAPHY = 0.18
_MOST_SEEDS = 60
_FARTHEST_OFF_PX = 8.0
_NEAREST_OFF_PX = 0.05
_FAR_OFF_PX = 0.3
_FAR_OFF_SIGMAS = 5.0
_SIZE_RATIO = 1.7
_STEPS: tuple[Node, ...] = ((0, 1), (1, 0), (0, -1), (-1, 0))


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Points that lie on a common projected lattice, with whole coordinates from any origin.

    Attributes
    ----------
    node
        Shape (N, 2), coordinates on the lattice.
    index
        Shape (N,), which of the points given.
    picture_from_node
        Shape (3, 3), the homography from lattice to picture.
    """

    node: IntArray
    index: IntArray
    picture_from_node: FloatArray

    def __len__(self) -> int:
        return len(self.index)

    def predict(self, node: IntArray | FloatArray) -> FloatArray:
        """Return where nodes, shape (N, 2), are seen, px."""
        return apply_homography(self.picture_from_node, np.asarray(node, dtype=np.float64))

    def extent(self, rows: int, cols: int) -> tuple[IntArray, IntArray]:
        """Return the first and last nodes, shape (2,) each, where points of a target may be.

        Where fewer lines are seen than the target has, as many as are missing are added on
        either side.
        """
        low, high = self.node.min(axis=0), self.node.max(axis=0)
        seen = high - low + 1
        upright = np.maximum([rows, cols] - seen, 0)
        turned = np.maximum([cols, rows] - seen, 0)
        missing = upright if upright.sum() <= turned.sum() else turned
        return low - missing, high + missing

    def within_target(self, rows: int, cols: int) -> tuple[BoolArray, IntArray]:
        """Return which points may be the target's, and the nodes where more of it may be.

        Where the numbering is certain already, these are the target's own nodes; else all
        within the extent.

        Returns
        -------
        mine
            Shape (N,).
        empty
            Shape (M, 2), nodes at which no point is known.
        """
        numbering = number(self.node, self.picture_from_node, rows, cols)
        mine, empty = np.ones(len(self), dtype=bool), self._empty_nodes(rows, cols)
        if numbering is None:
            return mine, empty
        mine = inside_target(numbering.rows_and_cols(self.node), rows, cols)
        return mine, empty[inside_target(numbering.rows_and_cols(empty), rows, cols)]

    def _empty_nodes(self, rows: int, cols: int) -> IntArray:
        low, high = self.extent(rows, cols)
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        taken = set(map(tuple, self.node.tolist()))
        empty = [
            n for n in zip(u.ravel().tolist(), v.ravel().tolist(), strict=True) if n not in taken
        ]
        return np.array(empty, dtype=np.int64).reshape(-1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Numbering:
    """The map from lattice coordinates to row and column: ``(row, col) = turn @ node + shift``."""

    turn: IntArray  # (2, 2)
    shift: IntArray  # (2,)

    def rows_and_cols(self, node: IntArray) -> IntArray:
        """Return (row, col), shape (N, 2)."""
        return node @ self.turn.T + self.shift

    def nodes(self, place: IntArray) -> IntArray:
        """Return the lattice coordinates of (row, col), shape (N, 2)."""
        return (place - self.shift) @ self.turn


def apply_homography(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Map points, shape (N, 2)."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return mapped[:, :2] / mapped[:, 2:]


def find_lattice(points_px: FloatArray, size_px: FloatArray, wanted: int) -> Lattice | None:
    """Find the largest projected lattice among points.

    Parameters
    ----------
    points_px
        Shape (N, 2), the target's points among others.
    size_px
        Shape (N,): neighbours are of like size.
    wanted
        How many points the target has: the search ends when nearly as many are found.

    Returns
    -------
    Lattice or None
        None where fewer than six points lie on a common lattice.
    """
    if len(points_px) < 6:
        return None
    distance = np.linalg.norm(points_px[:, None] - points_px[None], axis=2)
    unlike = np.abs(np.log(size_px[:, None] / size_px[None])) > np.log(_SIZE_RATIO)
    distance[unlike] = np.inf
    np.fill_diagonal(distance, np.inf)
    best: Lattice | None = None
    tried = np.zeros(len(points_px), dtype=bool)
    for seed in _seed_order(points_px)[:_MOST_SEEDS]:
        if tried[seed]:
            continue
        for basis in _bases(points_px, distance, seed):
            grown = _grow(points_px, size_px, seed, basis)
            lattice = _checked(points_px, size_px, grown)
            if lattice is not None and (best is None or len(lattice) > len(best)):
                best = lattice
                tried[lattice.index] = True
        if best is not None and len(best) >= 0.9 * wanted:
            break
    return best


def _seed_order(points_px: FloatArray) -> IntArray:
    """Return points by distance from the median: the middle of a target is the best start."""
    return np.argsort(np.linalg.norm(points_px - np.median(points_px, axis=0), axis=1))


def _bases(points_px: FloatArray, distance: FloatArray, seed: int) -> list[FloatArray]:
    """Return pairs of steps, shape (2, 2), from a point to two of its nearest neighbours."""
    near = np.argsort(distance[seed])[:6]
    near = near[np.isfinite(distance[seed, near])]
    steps = points_px[near] - points_px[seed]
    bases = []
    for i in range(len(near)):
        for j in range(i + 1, len(near)):
            one, other = steps[i], steps[j]
            sine = abs(one[0] * other[1] - one[1] * other[0])
            sine /= np.linalg.norm(one) * np.linalg.norm(other)
            if sine > 0.5:
                bases.append(np.stack([one, other]))
    return bases[:3]


def _grow(
    points_px: FloatArray, size_px: FloatArray, seed: int, basis: FloatArray
) -> dict[Node, int]:
    """Go from neighbour to neighbour, each predicted from those already found."""
    found: dict[Node, int] = {(0, 0): seed}
    used = {seed}
    queue = deque([(0, 0)])
    while queue:
        node = queue.popleft()
        for step in _STEPS:
            target = (node[0] + step[0], node[1] + step[1])
            if target in found:
                continue
            move = _expected_step(points_px, found, node, step, basis)
            expected = points_px[found[node]] + move
            gap = np.hypot(*(points_px - expected).T)
            nearest = int(gap.argmin())
            like = abs(np.log(size_px[nearest] / size_px[found[node]])) < np.log(_SIZE_RATIO)
            if gap[nearest] < _NEAR_PREDICTION * np.hypot(*move) and like and nearest not in used:
                found[target] = nearest
                used.add(nearest)
                queue.append(target)
    return found


def _expected_step(
    points_px: FloatArray, found: dict[Node, int], node: Node, step: Node, basis: FloatArray
) -> FloatArray:
    """Return the step to a neighbour: as the last one in that direction, or as one beside."""
    here = points_px[found[node]]
    back = found.get((node[0] - step[0], node[1] - step[1]))
    if back is not None:
        return np.asarray(here - points_px[back])
    for side in ((step[1], step[0]), (-step[1], -step[0])):
        start = (node[0] + side[0], node[1] + side[1])
        end = (start[0] + step[0], start[1] + step[1])
        if start in found and end in found:
            return np.asarray(points_px[found[end]] - points_px[found[start]])
        end = (start[0] - step[0], start[1] - step[1])
        if start in found and end in found:
            return np.asarray(points_px[found[start]] - points_px[found[end]])
    return np.asarray(step[0] * basis[0] + step[1] * basis[1])


def _checked(points_px: FloatArray, size_px: FloatArray, found: dict[Node, int]) -> Lattice | None:
    """Keep what one homography explains, and add the points that it predicts."""
    if len(found) < 6:
        return None
    node = _unsheared(np.array(list(found), dtype=np.int64))
    index = np.array(list(found.values()), dtype=np.int64)
    if np.linalg.matrix_rank(node - node[0]) < 2:
        return None
    pitch = _pitch_px(points_px, dict(zip(map(tuple, node.tolist()), index.tolist(), strict=True)))
    homography, agree = cv2.findHomography(
        node.astype(np.float64), points_px[index], cv2.RANSAC, _NEAR_HOMOGRAPHY * pitch
    )
    if homography is None or agree.sum() < 6:
        return None
    kept = Lattice(node[agree.ravel() > 0], index[agree.ravel() > 0], homography)
    return _with_predicted(points_px, size_px, kept, pitch)


def _unsheared(node: IntArray) -> IntArray:
    """Return lattice coordinates in the basis in which they fill a box best.

    Seen at an angle, a diagonal may look like the step to a neighbour. Of all sheared bases the
    target's own has the smallest product of variances: in it alone rows and columns are
    independent.
    """
    shears = [np.array([[1, k], [0, 1]]) for k in (-1, 1)]
    shears += [shear.T for shear in shears]
    while True:
        options = [node @ shear for shear in shears]
        smallest = min(options, key=_spread)
        if _spread(smallest) >= _spread(node):
            return node
        node = smallest


def _spread(node: IntArray) -> float:
    return float(np.prod(node.var(axis=0)))


def _pitch_px(points_px: FloatArray, found: dict[Node, int]) -> float:
    steps = [
        np.linalg.norm(points_px[other] - points_px[here])
        for (i, j), here in found.items()
        for other in (found.get((i + 1, j)), found.get((i, j + 1)))
        if other is not None
    ]
    return float(np.median(steps))


def _with_predicted(
    points_px: FloatArray, size_px: FloatArray, lattice: Lattice, pitch: float
) -> Lattice:
    """Add points near empty nodes in and next to the lattice."""
    low, high = lattice.node.min(axis=0) - 1, lattice.node.max(axis=0) + 1
    grid = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high, strict=True))), -1)
    taken = {tuple(node) for node in lattice.node.tolist()}
    empty = np.array([n for n in grid.reshape(-1, 2).tolist() if tuple(n) not in taken])
    if empty.size == 0:
        return lattice
    gap = np.linalg.norm(lattice.predict(empty)[:, None] - points_px[None], axis=2)
    nearest = gap.argmin(axis=1)
    like = np.abs(np.log(size_px[nearest] / np.median(size_px[lattice.index]))) < np.log(
        _SIZE_RATIO
    )
    good = (gap.min(axis=1) < _NEAR_HOMOGRAPHY * pitch) & like
    good &= ~np.isin(nearest, lattice.index)
    return Lattice(
        np.concatenate([lattice.node, empty[good]]),
        np.concatenate([lattice.index, nearest[good]]),
        lattice.picture_from_node,
    )


def number(node: IntArray, picture_from_node: FloatArray, rows: int, cols: int) -> Numbering | None:
    """Decide which lattice coordinates are row 0 and column 0.

    Parameters
    ----------
    node
        Shape (N, 2), the nodes that are seen.
    picture_from_node
        Shape (3, 3).
    rows, cols
        Of the target.

    Returns
    -------
    Numbering or None
        None where it is not certain: a border row or column is not seen, or what is seen fits
        the target in two places.
    """
    options = []
    for upright in (True, False):
        size = (rows, cols) if upright else (cols, rows)
        corner = _window(node, size)
        if corner is not None:
            seen = int((((node - corner) >= 0) & ((node - corner) < size)).all(axis=1).sum())
            options.append((seen, corner, upright))
    if rows != cols and len(options) > 1:
        options = (
            [max(options, key=lambda option: option[0])] if (options[0][0] != options[1][0]) else []
        )
    turned = [
        _oriented(corner, upright, picture_from_node, rows, cols) for _, corner, upright in options
    ]
    return max(turned, key=lambda pair: pair[0])[1] if turned else None


def _window(node: IntArray, size: tuple[int, int]) -> IntArray | None:
    """Return the corner of the only place where a window of `size` holds what is seen.

    Every border line of the window must be seen by a third of its points, two at least; of
    what lies outside there must be little.
    """
    corner = np.empty(2, dtype=np.int64)
    for axis in (0, 1):
        line = np.bincount(node[:, axis] - node[:, axis].min())
        if len(line) < size[axis]:
            return None
        held = np.convolve(line, np.ones(size[axis], dtype=np.int64), mode="valid")
        best = int(held.argmax())
        across = size[1 - axis]
        first, last = line[best], line[best + size[axis] - 1]
        outside = np.delete(line, np.arange(best, best + size[axis]))
        least = max(2.0, 0.34 * across)
        # Points outside are chance finds: fewer than half of what the border line holds.
        chance = outside.max() if outside.size else 0
        if not (min(first, last) >= least and chance <= 0.5 * min(first, last)):
            return None
        corner[axis] = best + node[:, axis].min()
    return corner


def _oriented(
    corner: IntArray, upright: bool, picture_from_node: FloatArray, rows: int, cols: int
) -> tuple[float, Numbering]:
    """Turn the numbering so that it is right-handed as seen and its rows run down.

    Also return how much the rows run down, from -1 to 1.
    """
    best: tuple[float, Numbering] | None = None
    to_rows = np.eye(2, dtype=np.int64) if upright else np.array([[0, 1], [1, 0]])
    for row_sign in (1, -1):
        for col_sign in (1, -1):
            turn = np.diag([row_sign, col_sign]) @ to_rows
            first = turn @ corner
            shift = np.array([
                -first[0] if row_sign > 0 else rows - 1 - first[0],
                -first[1] if col_sign > 0 else cols - 1 - first[1],
            ])
            numbering = Numbering(turn, shift)
            middle = np.array([[(rows - 1) // 2, (cols - 1) // 2]])
            here, down, right = (
                apply_homography(
                    picture_from_node, numbering.nodes(middle + np.array(move)).astype(np.float64)
                )[0]
                for move in ((0, 0), (1, 0), (0, 1))
            )
            row_step, col_step = down - here, right - here
            handed = col_step[0] * row_step[1] - col_step[1] * row_step[0]
            downwards = float(row_step[1] / np.hypot(*row_step))
            if handed > 0.0 and (best is None or downwards > best[0]):
                best = (downwards, numbering)
    if best is None:
        raise AssertionError("two of the four turns of a lattice are right-handed")
    return best


def inside_target(place: IntArray, rows: int, cols: int) -> BoolArray:
    """Return which (row, col), shape (N, 2), the target has."""
    return np.asarray(((place >= 0) & (place < [rows, cols])).all(axis=1))


def agreeing(
    place: IntArray, centre_px: FloatArray, sigma_px: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Fit the map from (row, col) to the picture, and tell which points agree with it.

    Parameters
    ----------
    place
        Shape (N, 2), (row, col).
    centre_px, sigma_px
        Shape (N, 2).

    Returns
    -------
    homography
        Shape (3, 3).
    agree
        Shape (N,). A lens bends a target by up to some pixels: smoothly, as a polynomial of the
        third degree follows. What is off by more than that, by its own sigma and by what is
        usual in the picture, is no point of the target, or one that light has displaced.
    """
    homography, near = cv2.findHomography(
        place.astype(np.float64), centre_px, cv2.RANSAC, _FARTHEST_OFF_PX
    )
    if homography is None:
        raise AssertionError("points that were numbered by a homography have one")
    agree = near.ravel() > 0
    off = centre_px - apply_homography(homography, place.astype(np.float64))
    x, y = ((place - place.mean(axis=0)) / max(float(np.ptp(place)), 1.0)).T
    bend = np.stack([x**i * y**j for i in range(4) for j in range(4 - i)], axis=1)
    weight = agree / np.maximum(sigma_px.max(axis=1), _NEAREST_OFF_PX)
    for _ in range(6):
        shape = np.linalg.lstsq(bend * weight[:, None], off * weight[:, None])[0]
        rest = np.linalg.norm(off - bend @ shape, axis=1)
        limit = np.maximum(_NEAREST_OFF_PX, 3.0 * sigma_px.max(axis=1))
        weight = agree / limit / (1.0 + (rest / limit) ** 2)
    usual = float(np.median(rest[agree])) / 1.1774  # the median of two normal parts, as a sigma
    limit = np.maximum(_FAR_OFF_PX, _FAR_OFF_SIGMAS * np.maximum(sigma_px.max(axis=1), usual))
    return homography, agree & (rest <= limit)
