"""The bounded multi-step search for the deviations of all points (Eq. 18 of the paper)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.sparse import csc_array, diags_array, eye_array, hstack, vstack
from scipy.sparse.linalg import splu

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.errors import NotConverged
from calib.solving.deviation.back_projection import BackProjection
from calib.solving.deviation.cross_ratios import cross_ratio, fours_of
from calib.solving.deviation.dot_terms import Blunt, dot_terms
from calib.solving.deviation.reach import SIGMAS_ALLOWED
from calib.solving.deviation.state import Frame, State
from calib.solving.deviation.stripe_terms import lines_on_boards, stripe_terms
from calib.solving.deviation.terms import Distances

# A length of one sigma costs this part of a distance of one (least) sigma: enough to choose among
# the corrections that make all distances zero, too little to leave one of them above zero.
_LENGTH_WEIGHT = 0.01
# Distances this part of the least sigma count by their square: blunt first, for a sharp sum lets
# a walk go only in small steps along the curve where it is zero.
_BLUNT, _SHARP = 1.0, 0.01
# A step that lowers the sum by less than this part of it is the last.
_SETTLED = 1e-6
_MOST_STEPS = 60
_MOST_HALVINGS = 8

_Terms = Callable[[State], Sequence[Distances]]


@dataclass(frozen=True, slots=True, eq=False)
class Relocation:
    """The end of the search.

    Attributes
    ----------
    state
        Deviations, poses, light plane.
    cost
        The sum of distances, px and mm added as in the paper, with the small cost of length.
    steps
        Taken in all.
    settled
        The sum had stopped falling.
    """

    state: State
    cost: float
    steps: int
    settled: bool


def relocate(frame: Frame, state: State) -> Relocation:
    """Find the deviations: of the dots, then of the stripe, then of all together.

    Parameters
    ----------
    frame
        What is seen.
    state
        The start, of no deviations.

    Raises
    ------
    NotConverged
        If the points leave a pose or the plane undetermined.

    Notes
    -----
    Any rigid poses and any plane make the paper's sum of distances zero if the points are moved
    onto them; the bounds alone do not choose. Of all such corrections the least is taken, in
    units of sigma: with the paper's start of no deviations, that is where steps of least length
    lead. Each step solves the re-weighted squares of the distances; deviations that meet their
    bound stay there until the sum pulls them back.
    """
    search = _Search.of(frame, state)
    fours = fours_of(frame.observations.dots)
    shift = search.small_shift(state, fours)

    def dots(at: State, part: float) -> Sequence[Distances]:
        return dot_terms(frame, at, fours, shift.times(part))

    def stripe(at: State, part: float) -> Sequence[Distances]:
        return stripe_terms(frame, at, part * shift.on_board_mm)

    def together(at: State, part: float) -> Sequence[Distances]:
        return [*dots(at, part), *stripe(at, part)]

    first = search.walk(
        partial(dots, part=_BLUNT), state, frame.masked(frame.dot_columns, frame.pose_columns)
    )
    straight = replace(first.state, lines=lines_on_boards(frame, first.state))
    second = search.walk(
        partial(stripe, part=_BLUNT),
        straight,
        frame.masked(frame.stripe_columns, frame.line_columns, frame.plane_columns),
    )
    ended, steps = second, first.steps + second.steps
    for part in (_BLUNT, _SHARP):
        ended = search.walk(
            partial(together, part=part), ended.state, np.ones(frame.size, dtype=bool)
        )
        steps += ended.steps
    return replace(ended, steps=steps)


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """What every step of the search needs.

    Attributes
    ----------
    frame
        What is seen.
    sigma_px, bound_px
        Shape (2 N + 2 S,), of the deviations in the order of the unknowns.
    least_px
        The smaller of the typical sigmas of dots and stripe.
    """

    frame: Frame
    sigma_px: FloatArray
    bound_px: FloatArray
    least_px: float

    @classmethod
    def of(cls, frame: Frame, state: State) -> "_Search":
        dots, stripe = frame.observations.dots, frame.observations.stripe
        split = np.abs(stripe.normal) * stripe.sigma_px[:, None]
        return cls(
            frame,
            np.concatenate([dots.sigma_px.ravel(), np.repeat(stripe.sigma_px, 2)]),
            SIGMAS_ALLOWED * np.concatenate([dots.sigma_px.ravel(), split.ravel()]),
            float(min(np.median(dots.sigma_px), np.median(stripe.sigma_px))),
        )

    def small_shift(self, state: State, fours: IntArray) -> Blunt:
        """Return the same small shift of a point in pixels, on the board and in a cross-ratio."""
        dots = self.frame.observations.dots
        back = BackProjection.of(dots.seen_px, dots.view, self.frame.camera, state.estimate)
        mm_per_px = float(np.median(np.abs(np.linalg.det(back.by_pixel)))) ** 0.5
        _, by_ray = cross_ratio(back.rays[fours, :2])
        by_px = by_ray[:, :, None] @ back.ray_by_pixel[fours, :2]
        ratio_per_px = (
            float(np.median(np.sqrt((by_px**2).sum(axis=(1, 2, 3))))) if len(fours) else 1.0
        )
        shift = self.least_px
        return Blunt(shift, shift * mm_per_px, shift * ratio_per_px)

    def walk(self, terms: _Terms, state: State, allowed: BoolArray) -> Relocation:
        """Walk down a sum of distances, some of the unknowns free."""
        found = terms(state)
        cost = self._cost(found, state)
        for steps in range(1, _MOST_STEPS + 1):
            step = self._step(found, state, allowed)
            for halving in range(_MOST_HALVINGS):
                trial = self.frame.moved(state, step * 0.5**halving, self.bound_px)
                trial_terms = terms(trial)
                trial_cost = self._cost(trial_terms, trial)
                if trial_cost <= cost:
                    break
            else:
                return Relocation(state, cost, steps, settled=True)
            fall, state, found, cost = cost - trial_cost, trial, trial_terms, trial_cost
            if fall <= _SETTLED * cost:
                return Relocation(state, cost, steps, settled=True)
        return Relocation(state, cost, _MOST_STEPS, settled=False)

    def _cost(self, terms: Sequence[Distances], state: State) -> float:
        length = self._deviations(state) / self.sigma_px
        cost = sum(term.cost for term in terms) + 0.5 * self._weight * float(length @ length)
        return cost if np.isfinite(cost) else np.inf

    def _step(self, terms: Sequence[Distances], state: State, allowed: BoolArray) -> FloatArray:
        """Return the step, shape (size,), of the re-weighted least squares."""
        count = len(self.sigma_px)
        narrow, side = _stacked([term for term in terms if not term.wide], self.frame.size)
        wide, wide_side = _stacked([term for term in terms if term.wide], self.frame.size)
        length = np.zeros(self.frame.size)
        length[:count] = self._weight / self.sigma_px**2
        gradient = narrow.T @ side
        gradient[:count] += length[:count] * self._deviations(state)
        free = allowed.copy()
        free[:count] &= ~self._pressed(state, gradient + wide.T @ wide_side)
        normal = narrow.T @ narrow + diags_array(length)
        index = np.flatnonzero(free & (normal.diagonal() > 0.0))
        step = np.zeros(self.frame.size)
        step[index] = -_solved(
            normal[index][:, index], wide[:, index], np.append(gradient[index], wide_side)
        )
        return step

    def _pressed(self, state: State, gradient: FloatArray) -> BoolArray:
        """Tell the deviations on their bound that the sum would drive farther out."""
        deviation = self._deviations(state)
        outward = -gradient[: len(deviation)] * np.sign(deviation) >= 0.0
        return np.asarray((np.abs(deviation) >= self.bound_px) & outward)

    def _deviations(self, state: State) -> FloatArray:
        return np.concatenate([state.dots_px.ravel(), state.stripe_px.ravel()])

    @property
    def _weight(self) -> float:
        return _LENGTH_WEIGHT * self.least_px


def _stacked(terms: Sequence[Distances], size: int) -> tuple[csc_array, FloatArray]:
    """Return Jacobian and differences of several terms, whitened."""
    if not terms:
        return csc_array((0, size)), np.zeros(0)
    rows = [term.rows(size) for term in terms]
    return csc_array(vstack([matrix for matrix, _ in rows])), np.concatenate([r for _, r in rows])


def _solved(normal: csc_array, wide: csc_array, side: FloatArray) -> FloatArray:
    """Solve ``(normal + wide^T wide) x = side[:n] + wide^T side[n:]``.

    The rows of `wide` reach over whole pictures; their squares would fill the matrix. Standing
    beside it, each with an unknown of its own, they do not (a quasi-definite matrix, which can be
    factorised in any order [1]_).

    References
    ----------
    .. [1] R. J. Vanderbei, "Symmetric quasidefinite matrices", SIAM J. Optim. 5, 1995.
    """
    count, extra = normal.shape[0], wide.shape[0]
    scale = np.concatenate([1.0 / np.sqrt(normal.diagonal()), np.ones(extra)])
    whole = vstack([hstack([normal, wide.T]), hstack([wide, -eye_array(extra)])])
    try:
        factors = splu(
            csc_array(diags_array(scale) @ whole @ diags_array(scale)),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as singular:
        raise NotConverged(
            "the points leave a pose or the light plane undetermined; add pictures of the target "
            "in other places and tilts"
        ) from singular
    return np.asarray((scale * factors.solve(scale * side))[:count])
