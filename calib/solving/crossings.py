"""Where a stripe crosses the columns of a target's dots, by the cross-ratio."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.lines import fit_line
from calib.solving.cross_ratio import place_by_cross_ratio
from calib.target import Target
from calib.views import TargetPoints

# A crossing this many pitches beyond the outer dots is not on the target.
_BEYOND = 1.0
# The cross-ratio needs three known points.
_LEAST_DOTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class DotLine:
    """Dots of one column, or of one row where the stripe runs along the columns.

    Attributes
    ----------
    dots
        Indices into the view's points, shape (N,), N >= 3.
    place
        Shape (N,), their place along the line, in pitches.
    line
        Place of the line itself, in pitches.
    is_column
        Whether it is a column.
    """

    dots: IntArray
    place: FloatArray
    line: float
    is_column: bool


def crossed_lines(
    points: TargetPoints, target: Target, rays: FloatArray, stripe: FloatArray
) -> list[DotLine]:
    """Return the columns that a stripe crosses on the target, or the rows if those are more.

    Parameters
    ----------
    points, target
        The dots of a view, and the target they are on.
    rays
        Shape (N, 2), normalised coordinates of the dots.
    stripe
        Shape (3,), the stripe's line in normalised coordinates.
    """
    columns = _crossed(points.col, points.row, rays, stripe, target.rows, is_column=True)
    if len(columns) == target.cols:
        return columns
    rows = _crossed(points.row, points.col, rays, stripe, target.cols, is_column=False)
    return columns if len(columns) >= len(rows) else rows


def crossings_mm(
    lines: Sequence[DotLine], target: Target, rays: FloatArray, stripe: FloatArray
) -> FloatArray:
    """Return where a stripe crosses lines of dots, on the target, shape (M, 2).

    `rays` and `stripe` as in `crossed_lines`.
    """
    found = [
        (line.line, place) if line.is_column else (place, line.line)
        for line in lines
        for place in (_crossing(line, rays, stripe),)
    ]
    return np.array(found).reshape(-1, 2) * target.pitch_mm


def _crossed(
    line_of: IntArray,
    place_on: IntArray,
    rays: FloatArray,
    stripe: FloatArray,
    count: int,
    *,
    is_column: bool,
) -> list[DotLine]:
    found = []
    for line in np.unique(line_of):
        dots = np.flatnonzero(line_of == line)
        if len(dots) < _LEAST_DOTS:
            continue
        candidate = DotLine(dots, place_on[dots].astype(np.float64), float(line), is_column)
        if -_BEYOND <= _crossing(candidate, rays, stripe) <= count - 1 + _BEYOND:
            found.append(candidate)
    return found


def _crossing(line: DotLine, rays: FloatArray, stripe: FloatArray) -> float:
    """Return the place of a crossing along its line, by the two outer dots and the middle one."""
    seen = rays[line.dots]
    column = fit_line(seen)
    point = np.cross(column, stripe)
    if not abs(point[2]) > 1e-12:
        return np.inf
    along = np.array([-column[1], column[0]])
    known = np.argsort(line.place)[[0, len(line.place) // 2, -1]]
    return float(
        place_by_cross_ratio(line.place[known], seen[known] @ along, point[:2] / point[2] @ along)
    )
