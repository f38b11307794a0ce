"""A projected lattice among points: neighbours of neighbours, where a homography expects them."""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.homography import apply_homography
from calib.seeing.numbering import inside_target, number

Node = tuple[int, int]

_NEAR_PREDICTION = 0.22  # of the step to a neighbour
_NEAR_HOMOGRAPHY = 0.18
_MOST_SEEDS = 60
_NEIGHBOURS = 8
_PAIRS_INSIDE = 2
_ENOUGH = 0.9  # of the target's points
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

    def likeness(self, rows: int, cols: int) -> int:
        """Return how many points a target of this shape could hold at most, less the others."""
        origin = self.node.min(axis=0)
        seen = np.zeros(np.ptp(self.node, axis=0) + 1)
        seen[tuple((self.node - origin).T)] = 1.0
        held = 0
        for height, width in ((rows, cols), (cols, rows)):
            padded = np.pad(seen, ((height, height), (width, width)))
            total = cv2.boxFilter(padded, -1, (width, height), normalize=False)
            held = max(held, round(float(total.max())))
        return 2 * held - len(self)

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


def find_lattice(
    points_px: FloatArray, size_px: FloatArray, rows: int, cols: int
) -> Lattice | None:
    """Find the projected lattice among points that is most like a target.

    Parameters
    ----------
    points_px
        Shape (N, 2), the target's points among others.
    size_px
        Shape (N,): neighbours are of like size.
    rows, cols
        Of the target: a wall of tiles or lamps behind it is a lattice too, but a larger one.

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
    most = -np.inf
    tried = np.zeros(len(points_px), dtype=bool)
    order = _seed_order(points_px, distance)
    for _ in range(_MOST_SEEDS):
        left = order[~tried[order]]
        if left.size == 0 or most >= _ENOUGH * rows * cols:
            break
        tried[left[0]] = True
        for basis in _bases(points_px, distance, int(left[0])):
            lattice = _checked(points_px, size_px, _grow(points_px, size_px, int(left[0]), basis))
            if lattice is None:
                continue
            tried[lattice.index] = True
            likeness = lattice.likeness(rows, cols)
            if likeness > most:
                best, most = lattice, likeness
    return best


def _seed_order(points_px: FloatArray, distance: FloatArray) -> IntArray:
    """Return points by how many pairs of like neighbours they lie midway between.

    Inside a lattice there are two such pairs and more, in a scatter of spots hardly one. Of equals
    the one nearest to the median comes first: the middle of a target is the best start.
    """
    count = min(_NEIGHBOURS, len(points_px) - 1)
    near = np.argpartition(distance, count, axis=1)[:, :count]
    step = points_px[near] - points_px[:, None]
    reachable = np.isfinite(np.take_along_axis(distance, near, axis=1))
    length = np.where(reachable, np.linalg.norm(step, axis=2), np.nan)
    off = np.linalg.norm(step[:, :, None] + step[:, None], axis=3)
    with np.errstate(invalid="ignore"):
        paired = off < _NEAR_PREDICTION * np.minimum(length[:, :, None], length[:, None])
    pairs = paired.sum(axis=(1, 2)) // 2
    from_middle = np.linalg.norm(points_px - np.median(points_px, axis=0), axis=1)
    return np.lexsort((from_middle, -np.minimum(pairs, _PAIRS_INSIDE)))


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
    kept = Lattice(node[agree.ravel() > 0], index[agree.ravel() > 0], np.asarray(homography))
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
