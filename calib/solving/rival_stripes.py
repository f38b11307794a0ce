"""Which of several lines on a board is the laser's: the one in the plane of all the others.

A reflection throws a second sheet that may be as bright and as straight as the first. One picture
cannot tell the two apart; but a reflection moves with the board, and the laser stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.camera import CameraModel
from calib.lines import fit_plane
from calib.solving.robust import robust_limit
from calib.solving.start import LEAST_STRIPE_POINTS, start_pose, stripe_line
from calib.target import Target
from calib.views import StripePoints, View

_MOST_CANDIDATES = 1000
_FEWEST_VIEWS = 3
"""Two lines of two pictures lie in some plane nearly always; a third tells."""
_AGREE = 4.0  # robust standard deviations


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """The lines of all candidates.

    `ends_mm` has shape (N, 2, 3), camera frame; `view` and `choice`, shape (N,), say whose they
    are and which of its candidates.
    """

    ends_mm: FloatArray
    view: IntArray
    choice: IntArray

    def misses_mm(self, plane: FloatArray) -> FloatArray:
        """Return how far each line is from a plane, shape (N,)."""
        return np.asarray(np.abs(self.ends_mm @ plane[:3] + plane[3]).max(axis=1))

    def best(self, misses_mm: FloatArray) -> IntArray:
        """Return the nearest candidate of each view, as indices into the lines."""
        order = np.lexsort((misses_mm, self.view))
        first = np.concatenate([[True], np.diff(self.view[order]) > 0])
        return np.asarray(order[first])


def settle_stripes(
    views: Sequence[View], usable: Sequence[int], target: Target, camera: CameraModel
) -> tuple[View, ...]:
    """Return the views with, for the stripe of each, the candidate that agrees with the others.

    Parameters
    ----------
    views
        What was seen; `View.rivals` hold the lines that may be the laser's as well.
    usable
        Indices of views whose points fix a pose.
    target, camera
        What is looked at, and with what.

    Returns
    -------
    views
        In the same order. A view changes only where its stripe is off the plane that most views
        agree on, and a rival is on it; the two then change places. Fewer than three views with
        stripes are returned as they are.

    Notes
    -----
    Of the planes through two candidates of different views each, the one is taken that has the
    smallest sum, over the views, of the distance of their nearest candidate (least absolute
    deviations over views and choices).
    """
    if not any(view.rivals for view in views):
        return tuple(views)
    lines = _lines(views, usable, target, camera)
    if len(np.unique(lines.view)) < _FEWEST_VIEWS:
        return tuple(views)
    misses = min(
        (lines.misses_mm(plane) for plane in _planes(lines)),
        key=lambda each: float(each[lines.best(each)].sum()),
    )
    nearest = lines.best(misses)
    limit = robust_limit(misses[nearest], _AGREE)
    settled = list(views)
    for line in nearest[(misses[nearest] <= limit) & (lines.choice[nearest] > 0)]:
        index = int(lines.view[line])
        own = misses[(lines.view == index) & (lines.choice == 0)]
        if not (own <= limit).any():
            settled[index] = exchanged(views[index], int(lines.choice[line]))
    return tuple(settled)


def _lines(
    views: Sequence[View], usable: Sequence[int], target: Target, camera: CameraModel
) -> _Lines:
    found = [
        (stripe_line(stripe, camera, pose).ends_mm, index, choice)
        for index, pose in ((i, start_pose(views[i], target, camera)) for i in usable)
        for choice, stripe in enumerate(_candidates(views[index]))
        if len(stripe) >= LEAST_STRIPE_POINTS
    ]
    return _Lines(
        np.array([ends for ends, _, _ in found]).reshape(-1, 2, 3),
        np.array([index for _, index, _ in found], dtype=np.int64),
        np.array([choice for _, _, choice in found], dtype=np.int64),
    )


def _planes(lines: _Lines) -> list[FloatArray]:
    pairs = [
        pair
        for pair in combinations(range(len(lines.view)), 2)
        if lines.view[pair[0]] != lines.view[pair[1]]
    ]
    if len(pairs) > _MOST_CANDIDATES:
        drawn = np.random.default_rng(0).choice(len(pairs), _MOST_CANDIDATES, replace=False)
        pairs = [pairs[i] for i in drawn]
    return [fit_plane(lines.ends_mm[list(pair)].reshape(-1, 3)) for pair in pairs]


def _candidates(view: View) -> tuple[StripePoints, ...]:
    return () if view.stripe is None else (view.stripe, *view.rivals)


def exchanged(view: View, choice: int) -> View:
    """Return a view whose stripe is another of its candidates, counted from the stripe itself."""
    candidates = _candidates(view)
    others = tuple(each for place, each in enumerate(candidates) if place != choice)
    return replace(view, stripe=candidates[choice], rivals=others)
