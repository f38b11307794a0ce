"""Numbering: which node of a lattice is row 0, column 0 of the target, where that is certain."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.homography import apply_homography

_SHEARS = tuple(
    np.array(rows)
    for rows in (
        [[1, 0], [0, 1]],
        [[1, 1], [0, 1]],
        [[1, -1], [0, 1]],
        [[1, 0], [1, 1]],
        [[1, 0], [-1, 1]],
    )
)
"""Strong perspective can make a diagonal neighbour look like the next of a row: the lattice's own
coordinates are then sheared, and so are tried with each shear undone."""

_MOST_OUTSIDE = 0.125
"""Of what the window holds. More is no chance: under a wrong shear a corner of the target lies
beyond each end of the window."""

_LEAST_SHEARED = 0.6
"""Share of the target that must be seen under a shear: fewer points fit a wrong one as well."""


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
        # A turn, a shear: whole numbers, whose inverse has whole numbers too.
        back = np.rint(np.linalg.inv(self.turn)).astype(np.int64)
        return (place - self.shift) @ back.T


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
    options = [
        _Option(int(_held(node @ shear.T, corner, size).sum()), corner, upright, shear)
        for shear in _SHEARS
        for upright, size in ((True, (rows, cols)), (False, (cols, rows)))
        if (corner := _window(node @ shear.T, size)) is not None
    ]
    least_sheared = _LEAST_SHEARED * rows * cols
    options = [
        each
        for each in options
        if len(node) - each.seen <= _MOST_OUTSIDE * each.seen
        and (each.shear is _SHEARS[0] or each.seen >= least_sheared)
    ]
    most = max((option.seen for option in options), default=0)
    best = [option for option in options if option.seen == most]
    # A square grid looks the same turned by 90 degrees; which way is up decides then.
    alike = rows == cols and all(option.shear is best[0].shear for option in best)
    if not best or (len(best) > 1 and not alike):
        return None
    turned = [_oriented(option, picture_from_node, rows, cols) for option in best]
    return max(turned, key=lambda pair: pair[0])[1]


@dataclass(frozen=True, slots=True, eq=False)
class _Option:
    """A window that may be the target: how many nodes it holds, and where it lies."""

    seen: int
    corner: IntArray
    upright: bool
    shear: IntArray


def _held(node: IntArray, corner: IntArray, size: tuple[int, int]) -> BoolArray:
    return np.asarray((((node - corner) >= 0) & ((node - corner) < size)).all(axis=1))


def _window(node: IntArray, size: tuple[int, int]) -> IntArray | None:
    """Return the corner of the only place where a window of `size` holds what is seen.

    Every border line of the window must be seen by a third of its points, two at least; of
    what lies outside there must be little.
    """
    if len(node) == 0:
        return None
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
    option: _Option, picture_from_node: FloatArray, rows: int, cols: int
) -> tuple[float, Numbering]:
    """Turn the numbering so that it is right-handed as seen and its rows run down.

    Also return how much the rows run down, from -1 to 1.
    """
    best: tuple[float, Numbering] | None = None
    to_rows = np.eye(2, dtype=np.int64) if option.upright else np.array([[0, 1], [1, 0]])
    for row_sign in (1, -1):
        for col_sign in (1, -1):
            turn = np.diag([row_sign, col_sign]) @ to_rows
            first = turn @ option.corner
            shift = np.array([
                -first[0] if row_sign > 0 else rows - 1 - first[0],
                -first[1] if col_sign > 0 else cols - 1 - first[1],
            ])
            numbering = Numbering(turn @ option.shear, shift)
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
