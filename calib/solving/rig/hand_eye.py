r"""How two cameras, and the boards that they look at, stand to each other: closed form, robust.

With the poses :math:`A_s` of one board before the first camera and :math:`B_s` of the other before
the second, one pair for each showing s of the rigid target,

.. math:: Z A_s = B_s Y, \quad Z = \text{second camera from first}, \quad
          Y = \text{second board from first}.

The turns between showings, as rotation vectors, obey :math:`\beta = R_Z \alpha`, whence the
rotation [1]_; the shifts are then linear. Three showings whose turns are not all about one axis
suffice, and sets of three are tried until the others agree [2]_. A board numbered from another
corner is but another pose, and all numberings are tried alike.

References
----------
.. [1] R. Y. Tsai and R. K. Lenz, "A new technique for fully autonomous and efficient 3D robotics
   hand/eye calibration", IEEE Transactions on Robotics and Automation 5(3), 1989; with the
   rotation by W. Kabsch, Acta Crystallographica A32, 1976.
.. [2] M. A. Fischler and R. C. Bolles, "Random sample consensus", Communications of the ACM 24(6),
   1981.
"""

from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.rigid import RigidTransform
from calib.solving.rig.closed_form import (
    FEWEST_SHOWINGS,
    Candidates,
    Numbered,
    answers_of_threes,
    solved_sets,
)

# A turn is worth the shift it makes at this distance: half a board.
_LEVER_MM = 50.0
# A showing that misses by more says no more than that it misses.
_MOST_MISS_MM = 5.0
# Of numberings that agree alike the first is to be taken: each later one costs as much.
_LATER_MM = 1e-6
# A showing disagrees when it misses by so many times what most miss, and by more than noise can.
_TIMES_USUAL, _LEAST_LIMIT_MM = 8.0, 0.5
# Cameras that stand so otherwise are another answer, not a less exact one.
_OTHERWISE_RAD = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """What pairs of poses agree on.

    Attributes
    ----------
    cameras, boards
        Second camera from first; second board from first.
    numbering
        Shape (N, 2), of the first and second board at each showing, as index.
    miss_mm, limit_mm
        Shape (N,), by how much each showing contradicts, a turn counted at half a board; more than
        the limit is too much.
    agreeing
        Shape (N,).
    rivalled
        As many showings agree, as well, on cameras that stand otherwise: the numberings are not
        told apart.
    """

    cameras: RigidTransform
    boards: RigidTransform
    numbering: IntArray
    miss_mm: FloatArray
    limit_mm: float
    agreeing: BoolArray
    rivalled: bool = False


def agree_on_both(first: Numbered, second: Numbered) -> Agreement | None:
    """Find how cameras and boards stand, neither known; None where no three showings tell."""
    tried = answers_of_threes(first, second)
    if len(tried.turn) == 0:
        return None
    misses_mm = _least_misses(tried, first, second)
    agreement = _judged(_best(tried, misses_mm), first, second)
    rivalled = _rivalled(tried, misses_mm, agreement)
    for _ in range(2):
        rows = np.flatnonzero(agreement.agreeing)
        if len(rows) < FEWEST_SHOWINGS:
            break
        a, b = _chosen(first, second, rows, agreement.numbering[rows])
        pairs = np.array(list(combinations(range(len(rows)), 2)))
        better = solved_sets(*a, *b, pairs[None], np.arange(len(rows))[None])
        agreement = _judged(better, first, second)
    return replace(agreement, rivalled=rivalled)


def agree_on_cameras(first: Numbered, second: Numbered, boards: RigidTransform) -> Agreement:
    """Find how the cameras stand, the second board from the first known."""
    maps = [there @ boards @ here.inverse() for here, there in _allowed(first, second)]
    return _agreed(maps, [boards] * len(maps), first, second)


def agree_on_boards(first: Numbered, second: Numbered, cameras: RigidTransform) -> Agreement:
    """Find how the boards stand, the second camera from the first known."""
    maps = [there.inverse() @ cameras @ here for here, there in _allowed(first, second)]
    return _agreed([cameras] * len(maps), maps, first, second)


def judge(
    first: Numbered, second: Numbered, cameras: RigidTransform, boards: RigidTransform
) -> Agreement:
    """Tell which showings agree with what is known of cameras and boards."""
    return _agreed([cameras], [boards], first, second)


def _allowed(first: Numbered, second: Numbered) -> list[tuple[RigidTransform, RigidTransform]]:
    """Return the pairs of poses of all showings, in all numberings that are not ruled out."""
    at = product(
        range(len(first.rotation)), *(range(each.rotation.shape[1]) for each in (first, second))
    )
    return [
        (_pose(first, showing, one), _pose(second, showing, other))
        for showing, one, other in at
        if first.allowed[showing, one] and second.allowed[showing, other]
    ]


def _pose(poses: Numbered, showing: int, numbering: int) -> RigidTransform:
    return RigidTransform(poses.rotation[showing, numbering], poses.place_mm[showing, numbering])


def _agreed(
    cameras: list[RigidTransform], boards: list[RigidTransform], first: Numbered, second: Numbered
) -> Agreement:
    tried = Candidates(
        np.array([each.rotation for each in cameras]),
        np.array([each.translation_mm for each in cameras]),
        np.array([each.rotation for each in boards]),
        np.array([each.translation_mm for each in boards]),
    )
    misses_mm = _least_misses(tried, first, second)
    agreement = _judged(_best(tried, misses_mm), first, second)
    return replace(agreement, rivalled=_rivalled(tried, misses_mm, agreement))


def _misses(tried: Candidates, first: Numbered, second: Numbered) -> FloatArray:
    """Return by how much showings contradict candidates, mm, shape (C, N, M1, M2)."""
    forth = tried.turn[:, None, None] @ first.rotation
    back = second.rotation @ tried.board_turn[:, None, None]
    trace = np.einsum("cnaij,cnbij->cnab", forth, back)
    turned = np.sqrt(np.maximum(3.0 - trace, 0.0))
    there = np.einsum("cij,naj->cnai", tried.turn, first.place_mm) + tried.shift[:, None, None]
    here = np.einsum("nbij,cj->cnbi", second.rotation, tried.board_shift) + second.place_mm
    shifted = np.linalg.norm(there[:, :, :, None] - here[:, :, None], axis=-1)
    allowed = first.allowed[:, :, None] & second.allowed[:, None]
    later = np.add.outer(np.arange(allowed.shape[1]), np.arange(allowed.shape[2])) * _LATER_MM
    return np.asarray(np.where(allowed, shifted + _LEVER_MM * turned + later, np.inf))


def _least_misses(tried: Candidates, first: Numbered, second: Numbered) -> FloatArray:
    """Return by how much showings contradict candidates in their best numbering, shape (C, N)."""
    return np.asarray(_misses(tried, first, second).min(axis=(2, 3)))


def _rivalled(tried: Candidates, misses_mm: FloatArray, found: Agreement) -> bool:
    """Tell whether cameras that stand otherwise find as many showings to agree."""
    trace = np.einsum("cij,ij->c", tried.turn, found.cameras.rotation)
    otherwise = (trace - 1.0) / 2.0 < np.cos(_OTHERWISE_RAD)
    agreeing = (misses_mm <= found.limit_mm).sum(axis=1)
    return bool((otherwise & (agreeing >= found.agreeing.sum())).any())


def _best(tried: Candidates, misses_mm: FloatArray) -> Candidates:
    """Return the candidate with the smallest sum of misses, none counted for more than the most."""
    best = int(np.argmin(np.minimum(misses_mm, _MOST_MISS_MM).sum(axis=1)))
    pick = slice(best, best + 1)
    return Candidates(
        tried.turn[pick], tried.shift[pick], tried.board_turn[pick], tried.board_shift[pick]
    )


def _judged(answer: Candidates, first: Numbered, second: Numbered) -> Agreement:
    misses = _misses(answer, first, second)[0]
    choice = misses.reshape(len(misses), -1).argmin(axis=1)
    miss = misses.min(axis=(1, 2))
    limit = max(_TIMES_USUAL * float(np.median(miss)), _LEAST_LIMIT_MM)
    limit = min(limit, _MOST_MISS_MM)
    return Agreement(
        cameras=RigidTransform(answer.turn[0], answer.shift[0]),
        boards=RigidTransform(answer.board_turn[0], answer.board_shift[0]),
        numbering=np.column_stack(np.unravel_index(choice, misses.shape[1:])),
        miss_mm=miss,
        limit_mm=limit,
        agreeing=np.asarray(miss <= limit),
    )


def _chosen(
    first: Numbered, second: Numbered, rows: IntArray, numbering: IntArray
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    one, other = numbering.T
    return (
        (first.rotation[rows, one], first.place_mm[rows, one]),
        (second.rotation[rows, other], second.place_mm[rows, other]),
    )
