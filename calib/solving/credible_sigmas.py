r"""Sigmas that promise too much beside others: found by the scatter they leave, and raised.

A common factor on all sigmas does no harm: the scale is estimated. Where sigmas differ, though, a
few that claim a hundredth of a pixel and scatter like all the rest draw the answer onto themselves.
So the points are sorted into classes of sigma, and where the scatter does not grow with sigma as
promised, it is described as

.. math:: s^2 (\sigma^2 + \tau^2),

with a scatter :math:`\tau` that all points of the kind share, and everything is solved again.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias, TypeVar

import numpy as np

from calib.arrays import FloatArray
from calib.calibration import Calibration, CameraCalibration, SolvedPoints
from calib.errors import NotConverged
from calib.views import View

_Answer = TypeVar("_Answer", Calibration, CameraCalibration)

# Classes are this factor of sigma wide; sigmas within it are not looked at.
_CLASS_WIDTH = 3.0
# A class of fewer points does not tell its scatter: of 12, a median is known to a quarter.
_LEAST_POINTS = 12
# Classes that exceed the usual actual over promised scatter by less are taken at their word.
_WORTH_RAISING = 3.0
# Renewals. The first shares a large scatter among both kinds: an answer drawn onto a few points
# hides what they scatter, one in which all points have a like say does not.
_ROUNDS = 4
# A shared scatter that changes by a smaller factor has settled.
_SETTLED = 1.2
# Median length of a standard normal vector of 1 and 2 dimensions.
_MEDIAN_LENGTH = {1: 0.674490, 2: 1.177410}


@dataclass(frozen=True, slots=True)
class _Shared:
    """Scatter that all points of a kind share beside their own sigma, px; 0 for none."""

    dots_px: float = 0.0
    stripe_px: float = 0.0

    def raised(self, view: View) -> View:
        """Return the view with sigmas that hold this scatter."""
        points, stripes = view.points, [view.stripe, *view.rivals]
        stripe, *rivals = (
            part and replace(part, sigma_px=np.hypot(part.sigma_px, self.stripe_px))
            for part in stripes
        )
        return replace(
            view,
            points=replace(points, sigma_px=np.hypot(points.sigma_px, self.dots_px)),
            stripe=stripe,
            rivals=tuple(part for part in rivals if part is not None),
        )

    def differs_from(self, other: "_Shared") -> bool:
        """Tell whether it differs enough to solve again."""
        return any(
            max(mine, theirs) > _SETTLED * min(mine, theirs)
            for mine, theirs in (
                (self.dots_px, other.dots_px),
                (self.stripe_px, other.stripe_px),
            )
        )

    def at_least(self, other: "_Shared") -> "_Shared":
        """Return the larger of two, of each kind."""
        return _Shared(max(self.dots_px, other.dots_px), max(self.stripe_px, other.stripe_px))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the reader should know."""
        return tuple(
            f"the smallest sigmas of the {kind} promise too much beside the others; {shared:.2g} "
            "px was added to all, in squares"
            for kind, shared in (
                ("target points", self.dots_px),
                ("stripe points", self.stripe_px),
            )
            if shared > 0.0
        )


_NONE = _Shared()
_Solved: TypeAlias = tuple[_Answer, Sequence[View]]
_Solve: TypeAlias = Callable[[Sequence[View]], _Solved[_Answer]]


def solved_credibly(solve: _Solve[_Answer], views: Sequence[View]) -> _Answer:
    """Solve views, and again with raised sigmas where these do not agree with the scatter.

    Parameters
    ----------
    solve
        Returns an answer and the views as it used them.
    views
        What was seen.

    Raises
    ------
    CalibError
        As `solve`. One that does not converge is tried once more, no sigma below the median.
    """
    shared, solved = _first(solve, views)
    for _ in range(_ROUNDS):
        found = _found(*solved, shared)
        if not found.differs_from(shared):
            break
        if shared == _NONE:
            found = found.at_least(_medians(views))
        shared = found
        solved = solve([shared.raised(view) for view in views])
    return _told(solved[0], shared)


def _told(answer: _Answer, shared: _Shared) -> _Answer:
    return replace(answer, warnings=(*answer.warnings, *shared.warnings))


def _first(solve: _Solve[_Answer], views: Sequence[View]) -> tuple[_Shared, _Solved[_Answer]]:
    try:
        return _NONE, solve(views)
    except NotConverged:
        shared = _medians(views)
        if shared == _NONE:
            raise
        return shared, solve([shared.raised(view) for view in views])


def _found(
    answer: Calibration | CameraCalibration, used: Sequence[View], shared: _Shared
) -> _Shared:
    pairs = list(zip(answer.views, used, strict=True))
    dots = _scatter(
        (solved.dots, seen.points.centre_px, np.sqrt((seen.points.sigma_px**2).mean(axis=1)))
        for solved, seen in pairs
    )
    stripe = _scatter(
        (solved.stripe, seen.stripe.centre_px, seen.stripe.sigma_px)
        for solved, seen in pairs
        if seen.stripe is not None and solved.stripe is not None and solved.stripe.used.any()
    )
    return _Shared(
        _shared_px(*dots, shared.dots_px, dimensions=2),
        _shared_px(*stripe, shared.stripe_px, dimensions=1),
    )


def _scatter(
    parts: Iterable[tuple[SolvedPoints | None, FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    """Return the lengths of deviations and the sigmas of all points solved, shapes (N,)."""
    lengths, sigmas = [np.empty(0)], [np.empty(0)]
    for solved, seen_px, sigma_px in parts:
        if solved is not None:
            lengths.append(np.linalg.norm(seen_px - solved.corrected_px, axis=1))
            sigmas.append(sigma_px)
    return np.concatenate(lengths), np.concatenate(sigmas)


def _shared_px(
    length_px: FloatArray, raised_px: FloatArray, already_px: float, *, dimensions: int
) -> float:
    """Return tau of the points of one kind, 0 where the sigmas agree with the scatter."""
    # Sigmas as they were told; raising them is undone up to rounding.
    sigma_px = np.sqrt(np.maximum(raised_px**2 - already_px**2, 1e-12 * raised_px**2))
    each_px = length_px / _MEDIAN_LENGTH[dimensions]
    classes = _classes(each_px, sigma_px)
    if len(classes) < 2:
        return 0.0
    scatter, told, count = np.array(classes).T
    # Beside what most points do: a few that promise too little, as dots in glare, draw nothing.
    usual = max(float(np.median(each_px / sigma_px)), 1e-9)
    if not (scatter / told).max() > _WORTH_RAISING * usual:
        return 0.0
    candidates = np.geomspace(told.min() / _CLASS_WIDTH, told.max() * _CLASS_WIDTH, 100)
    excess = np.log(scatter) - np.log(np.hypot(told, candidates[:, None]))
    excess -= np.average(excess, axis=1, weights=count)[:, None]
    return float(candidates[np.argmin(excess**2 @ count)])


def _classes(scatter_px: FloatArray, sigma_px: FloatArray) -> list[tuple[float, float, float]]:
    """Return (median scatter, median sigma, count) of each class, the largest sigma first."""
    if len(sigma_px) == 0:
        return []
    place = np.floor(np.log(sigma_px.max() / sigma_px) / np.log(_CLASS_WIDTH))
    return [
        (
            max(float(np.median(scatter_px[place == each])), 1e-9),
            float(np.median(sigma_px[place == each])),
            float(np.count_nonzero(place == each)),
        )
        for each in np.unique(place)
        if np.count_nonzero(place == each) >= _LEAST_POINTS
    ]


def _medians(views: Sequence[View]) -> _Shared:
    dots = np.concatenate([np.empty(0), *(view.points.sigma_px.ravel() for view in views)])
    stripes = [view.stripe.sigma_px for view in views if view.stripe is not None]
    return _Shared(
        *(
            float(np.median(sigma)) if len(sigma) and np.ptp(sigma) > 0.0 else 0.0
            for sigma in (dots, np.concatenate([np.empty(0), *stripes]))
        )
    )
