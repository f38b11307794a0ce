"""Where prisms lie in space, and sensors beside each other: all points at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from calib import FloatArray, RigidTransform, moved_by
from measure.piece.certified import Piece
from measure.piece.rig.contact import POSE_PARAMETERS, Contact, stepped, touch

_RIG_PARAMETERS = 6
_ROUNDS = 40
_SETTLED = 1e-9
_FIRST_DAMPING = 1e-6
_MOST_DAMPING = 1e6
_HELD_RAD = 1e-5
_HELD_MM = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Placing:
    """One placing of the piece.

    Attributes
    ----------
    contacts
        The points of each sensor that saw it.
    rig_from_piece
        Its pose.
    square_to
        Shape (3,), unit, rig frame: the direction in which its length should point.
    slant_sigma_rad
        How well it does, about each axis.
    """

    contacts: tuple[Contact, ...]
    rig_from_piece: RigidTransform
    square_to: FloatArray
    slant_sigma_rad: float

    @property
    def slant_rad(self) -> FloatArray:
        """Turns about the piece's x and z by which its length has left `square_to`, shape (2,)."""
        x, y, z = self.rig_from_piece.rotation.T @ self.square_to
        sign = 1.0 if y >= 0.0 else -1.0
        return np.array([z, -x]) * sign


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of the sensors' poses beforehand.

    Attributes
    ----------
    poses
        rig_from_camera of each.
    precision
        Shape (K, 6, 6), of each: the inverse of its covariance, in the order of
        `calib.POSE_PARAMETERS`.
    """

    poses: tuple[RigidTransform, ...]
    precision: FloatArray

    @classmethod
    def within(cls, poses: Sequence[RigidTransform], sigma_mm: float, sigma_rad: float) -> Self:
        """Know all poses alike: places along, and turns about, each axis."""
        precision = np.diag(np.repeat([sigma_rad**-2, sigma_mm**-2], 3))
        return cls(tuple(poses), np.tile(precision, (len(poses), 1, 1)))

    def but_within_section(self, length: FloatArray) -> Self:
        """Hold all that leaves the section of a piece of that direction, shape (3,), unit."""
        out = np.outer(length, length)
        held = self.precision.copy()
        held[:, :3, :3] += (np.eye(3) - out) / _HELD_RAD**2
        held[:, 3:, 3:] += out / _HELD_MM**2
        return replace(self, precision=held)

    def of(self, free: Sequence[int]) -> FloatArray:
        """Return the precision of some of them as one matrix, shape (6 F, 6 F)."""
        whole = np.zeros((_RIG_PARAMETERS * len(free),) * 2)
        for place, index in enumerate(free):
            here = slice(_RIG_PARAMETERS * place, _RIG_PARAMETERS * (place + 1))
            whole[here, here] = self.precision[index]
        return whole

    def off(self, poses: Sequence[RigidTransform]) -> FloatArray:
        """Return the steps that lead from what is known to poses, shape (K, 6)."""
        return np.stack([
            np.concatenate([
                (pose @ known.inverse()).rotation_vector,
                pose.translation_mm - known.translation_mm,
            ])
            for pose, known in zip(poses, self.poses, strict=True)
        ])


@dataclass(frozen=True, slots=True, eq=False)
class Normal:
    """Normal equations: each placing's own block, the sensors', and what couples them.

    Attributes
    ----------
    cost
        Sum of the squares of all that is weighted.
    own, own_gradient
        Shape (M, 5, 5) and (M, 5).
    coupling
        Shape (M, 5, 6 F), F sensors being free.
    rig, rig_gradient
        Shape (6 F, 6 F) and (6 F,).
    """

    cost: float
    own: FloatArray
    own_gradient: FloatArray
    coupling: FloatArray
    rig: FloatArray
    rig_gradient: FloatArray

    def reduced(self) -> FloatArray:
        """Return the information on the sensors' poses, the placings' taken for unknown."""
        own = _inverses(self.own)
        return np.asarray(
            self.rig - np.einsum("mpr,mpq,mqs->rs", self.coupling, own, self.coupling)
        )

    def foreseen(self, own: FloatArray, rig: FloatArray) -> float:
        """Return by how much steps should lower the cost, were all distances linear."""
        slope = float((self.own_gradient * own).sum() + self.rig_gradient @ rig)
        curved = float(np.einsum("mp,mpq,mq->", own, self.own, own) + rig @ self.rig @ rig)
        curved += 2.0 * float(np.einsum("mp,mpr,r->", own, self.coupling, rig))
        return -2.0 * slope - curved

    def step(self, damping: float) -> tuple[FloatArray, FloatArray]:
        """Return the steps of the placings, (M, 5), and of the sensors, (6 F,)."""
        inverse = _inverses(_damped(self.own, damping))
        taken = np.einsum("mpr,mpq->mrq", self.coupling, inverse)
        step = np.zeros(len(self.rig))
        if len(step):
            matrix = _damped(self.rig[None], damping)[0] - np.einsum(
                "mrq,mqs->rs", taken, self.coupling
            )
            gradient = self.rig_gradient - np.einsum("mrq,mq->r", taken, self.own_gradient)
            step = -_solve(matrix, gradient)
        rest = self.own_gradient + self.coupling @ step
        return -np.einsum("mpq,mq->mp", inverse, rest), step


def _damped(matrix: FloatArray, damping: float) -> FloatArray:
    diagonal = np.einsum("...ii->...i", matrix)
    return np.asarray(matrix + damping * np.eye(matrix.shape[-1]) * (diagonal[..., None] + 1e-12))


def _inverses(matrices: FloatArray) -> FloatArray:
    """Return inverses of positive blocks whose entries differ by many orders."""
    scale = np.sqrt(np.maximum(np.einsum("mii->mi", matrices), 1e-12))
    both = scale[:, :, None] * scale[:, None, :]
    return np.asarray(np.linalg.pinv(matrices / both, rcond=1e-12, hermitian=True) / both)


def _solve(matrix: FloatArray, gradient: FloatArray) -> FloatArray:
    return np.asarray(_inverses(matrix[None])[0] @ gradient)


def normal_equations(
    placings: Sequence[Placing],
    poses: Sequence[RigidTransform],
    piece: Piece,
    free: Sequence[int],
    known: Known | None,
) -> Normal:
    """Linearise all distances about poses; sensors of `free` may move, `known` holds them back."""
    count, rig_size = len(placings), _RIG_PARAMETERS * len(free)
    own, coupling = np.zeros((count, 5, 5)), np.zeros((count, POSE_PARAMETERS, rig_size))
    own_gradient, rig = np.zeros((count, 5)), np.zeros((rig_size, rig_size))
    rig_gradient, cost = np.zeros(rig_size), 0.0
    for index, placing in enumerate(placings):
        for contact in placing.contacts:
            seen = touch(contact, poses[contact.sensor], placing.rig_from_piece, piece)
            rest = contact.weight * seen.outside_mm
            by_pose = contact.weight[:, None] * seen.by_pose
            cost += float(rest @ rest)
            own[index] += by_pose.T @ by_pose
            own_gradient[index] += by_pose.T @ rest
            if contact.sensor in free:
                at = _RIG_PARAMETERS * free.index(contact.sensor)
                here = slice(at, at + _RIG_PARAMETERS)
                by_rig = contact.weight[:, None] * seen.by_rig
                rig[here, here] += by_rig.T @ by_rig
                rig_gradient[here] += by_rig.T @ rest
                coupling[index][:, here] += by_pose.T @ by_rig
        # The last two parameters turn the piece back to where its holder should keep it.
        slant, precision = placing.slant_rad, placing.slant_sigma_rad**-2
        cost += float(slant @ slant) * precision
        own[index, [3, 4], [3, 4]] += precision
        own_gradient[index, 3:] += precision * slant
    if known is not None and len(free):
        off, before = known.off(poses)[list(free)].ravel(), known.of(free)
        cost += float(off @ before @ off)
        rig += before
        rig_gradient += before @ off
    return Normal(cost, own, own_gradient, coupling, rig, rig_gradient)


def fit_prisms(
    placings: Sequence[Placing],
    poses: Sequence[RigidTransform],
    piece: Piece,
    *,
    free: Sequence[int] = (),
    known: Known | None = None,
) -> tuple[list[Placing], list[RigidTransform], float]:
    r"""Fit the poses of the piece in all placings, and of some sensors.

    Parameters
    ----------
    placings
        Points given to their sides, and where the piece is thought to lie.
    poses
        rig_from_camera of all sensors.
    piece
        Its profile.
    free
        Which sensors may move.
    known
        What holds them back; None: nothing does.

    Returns
    -------
    placings, poses
        As fitted; points keep their sides and weights.
    cost
        Sum of the squares of all that is weighted.

    Notes
    -----
    Levenberg-Marquardt; the placings' steps are eliminated, and the damping follows Nielsen's rule.

    References
    ----------
    .. [1] H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05, Technical
       University of Denmark, 1999.
    """
    now, cameras = list(placings), list(poses)
    damping, harder = _FIRST_DAMPING, 2.0
    normal = normal_equations(now, cameras, piece, free, known)
    for _ in range(_ROUNDS):
        own, rig = normal.step(damping)
        tried = [
            replace(one, rig_from_piece=stepped(one.rig_from_piece, step, piece))
            for one, step in zip(now, own, strict=True)
        ]
        moved = list(cameras)
        for index, step in zip(free, rig.reshape(-1, _RIG_PARAMETERS), strict=True):
            moved[index] = moved_by(cameras[index], step)
        after = normal_equations(tried, moved, piece, free, known)
        gain = normal.cost - after.cost
        if not gain >= 0.0:
            damping, harder = harder * damping, 2.0 * harder
            if damping > _MOST_DAMPING:
                break
            continue
        foreseen = normal.foreseen(own, rig)
        now, cameras, normal = tried, moved, after
        damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain / max(foreseen, 1e-12) - 1.0) ** 3)
        harder = 2.0
        if gain <= _SETTLED * max(after.cost, 1e-12):
            break
    return now, cameras, normal.cost
