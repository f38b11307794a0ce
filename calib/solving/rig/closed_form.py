"""How two cameras and two boards stand, from sets of showings, in closed form.

The equations, and where they are from, are told in `calib.solving.rig.hand_eye`.
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from scipy.spatial.transform import Rotation

from calib.arrays import BoolArray, FloatArray, IntArray

FEWEST_SHOWINGS = 3
# Of 60 sets of three, one has no false showing with a chance of 1 - 3e-4 where a half are false.
_MOST_TRIPLES = 60
# Of 4 x 4 x 4 numberings of three showings, by chance few pass; turns of a pair agree within this.
_ANGLES_AGREE_RAD = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Numbered:
    """Poses of a board before one camera at N showings, in each of M numberings.

    Attributes
    ----------
    rotation, place_mm
        Shapes (N, M, 3, 3) and (N, M, 3).
    allowed
        Shape (N, M), numberings that are not ruled out.
    """

    rotation: FloatArray
    place_mm: FloatArray
    allowed: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Many answers: rotations (C, 3, 3) and places (C, 3) of cameras and boards."""

    turn: FloatArray
    shift: FloatArray
    board_turn: FloatArray
    board_shift: FloatArray


def turns_between(poses: Numbered) -> FloatArray:
    """Return the turns between all showings, rad, along the axes of the camera, shape (N, 3).

    Of the numberings those are taken between which a board turns least.
    """
    found = []
    for one, other in combinations(range(len(poses.rotation)), 2):
        turned = poses.rotation[other] @ poses.rotation[one, 0].T
        vectors = Rotation.from_matrix(turned).as_rotvec()
        found.append(vectors[np.argmin(np.linalg.norm(vectors, axis=1))])
    return np.array(found).reshape(-1, 3)


def answers_of_threes(first: Numbered, second: Numbered) -> Candidates:
    """Return the answers of sets of three showings, in all numberings that may be."""
    count, m1, m2 = len(first.rotation), first.rotation.shape[1], second.rotation.shape[1]
    triples = np.array(list(combinations(range(count), 3)), dtype=np.int64).reshape(-1, 3)
    if len(triples) > _MOST_TRIPLES:
        triples = np.random.default_rng(0).choice(triples, _MOST_TRIPLES, replace=False)
    options = np.array(list(product(range(m1), range(m2))), dtype=np.int64)
    sets = np.array(list(product(range(len(options)), repeat=3)), dtype=np.int64)
    # Every triple with every set of numberings: rows (triple, set), columns the three showings.
    rows = np.repeat(triples, len(sets), axis=0)
    chosen = options[np.tile(sets, (len(triples), 1))]
    allowed = first.allowed[rows, chosen[:, :, 0]] & second.allowed[rows, chosen[:, :, 1]]
    keep = allowed.all(axis=1)
    for one, other in ((0, 1), (0, 2), (1, 2)):
        angles = [
            _angle(
                poses.rotation[rows[:, other], pick[:, other]],
                poses.rotation[rows[:, one], pick[:, one]],
            )
            for poses, pick in ((first, chosen[:, :, 0]), (second, chosen[:, :, 1]))
        ]
        keep &= np.abs(angles[0] - angles[1]) < _ANGLES_AGREE_RAD
    rows, chosen = rows[keep], chosen[keep]
    a = (first.rotation[rows, chosen[:, :, 0]], first.place_mm[rows, chosen[:, :, 0]])
    b = (second.rotation[rows, chosen[:, :, 1]], second.place_mm[rows, chosen[:, :, 1]])
    flat = [part.reshape(-1, *part.shape[2:]) for part in (*a, *b)]
    index = np.arange(3 * len(rows)).reshape(-1, 3)
    pairs = index[:, [[0, 1], [0, 2], [1, 2]]]
    return solved_sets(flat[0], flat[1], flat[2], flat[3], pairs, index)


def _angle(one: FloatArray, other: FloatArray) -> FloatArray:
    trace = np.einsum("nij,nij->n", one, other)
    return np.asarray(np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0)))


def solved_sets(
    a_turn: FloatArray,
    a_place: FloatArray,
    b_turn: FloatArray,
    b_place: FloatArray,
    pairs: IntArray,
    rows: IntArray,
) -> Candidates:
    """Solve sets of poses, each by its pairs, shape (C, Q, 2), and its rows, shape (C, N)."""
    one, other = pairs[..., 0], pairs[..., 1]
    alpha = _rotation_vectors(a_turn[other] @ a_turn[one].swapaxes(-1, -2))
    beta = _rotation_vectors(b_turn[other] @ b_turn[one].swapaxes(-1, -2))
    turn = _nearest_rotation(np.einsum("cqi,cqj->cij", beta, alpha))
    board_turn = _nearest_rotation(
        np.einsum("cnji,cjk,cnkl->cil", b_turn[rows], turn, a_turn[rows])
    )
    # [I, -R_B] (shift of the cameras, shift of the boards) = t_B - R_Z t_A, by normal equations;
    # the little on their diagonal keeps sets that tell nothing from being singular.
    against = b_turn[rows]
    side = b_place[rows] - np.einsum("cij,cnj->cni", turn, a_place[rows])
    normal = np.zeros((len(rows), 6, 6))
    normal[:, :3, :3] = normal[:, 3:, 3:] = rows.shape[1] * (1.0 + 1e-13) * np.eye(3)
    normal[:, :3, 3:] = -against.sum(axis=1)
    normal[:, 3:, :3] = normal[:, :3, 3:].swapaxes(1, 2)
    right = np.concatenate([side.sum(axis=1), -np.einsum("cnji,cnj->ci", against, side)], axis=1)
    shifts = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
    return Candidates(turn, shifts[:, :3], board_turn, shifts[:, 3:])


def _rotation_vectors(matrices: FloatArray) -> FloatArray:
    flat = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_rotvec()
    return np.asarray(flat.reshape(*matrices.shape[:-2], 3))


def _nearest_rotation(matrices: FloatArray) -> FloatArray:
    """Return the rotations nearest to matrices, shape (C, 3, 3)."""
    left, _, right = np.linalg.svd(matrices)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    return np.asarray(left @ right)
