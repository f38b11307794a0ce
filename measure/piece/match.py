"""Which point belongs to which side of a piece, and the pose in which most do."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from calib import FloatArray, IntArray
from measure.piece.certified import Piece
from measure.piece.search import PiecePose

MIN_POINTS = 60
"""Fewer points on the piece say nothing."""
_GATES_MM = (2.5, 1.5, 1.0, 1.0, 1.0, 1.0)
GATE_MM = _GATES_MM[-1]
"""Farther from the profile than this is something else."""
# Where two sides run beside each other, a point must not change from one to the other.
_GATE_OF_STEP = 0.3
_NO_STEP_MM = 1e-3
_ALIKE = 0.9
_USUAL_SIGMAS = 2.0
# A pose along which nothing is seen, as along a single step, stays where it was found.
_STIFFNESS = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """For each point its side (-1: none), its place along it, its distance, and the normal."""

    face: IntArray
    along_mm: FloatArray
    outside_mm: FloatArray
    normal: FloatArray


def matched(points_mm: FloatArray, normal: FloatArray, piece: Piece, gate: float) -> Match:
    """Give each point the nearest side that runs its way, within a gate."""
    nearest = np.full(len(points_mm), gate)
    match = Match(
        np.full(len(points_mm), -1, dtype=np.int64),
        np.zeros(len(points_mm)),
        np.zeros(len(points_mm)),
        np.zeros((len(points_mm), 2)),
    )
    for index, face in enumerate(piece.faces):
        along, outside = face.place(points_mm)
        _, out = face.points(along)
        here = (along >= 0.0) & (along <= face.length_mm) & (np.abs(outside) < nearest)
        here &= (out * normal).sum(axis=1) > _ALIKE
        nearest[here] = np.abs(outside[here])
        match.face[here], match.normal[here] = index, out[here]
        match.along_mm[here], match.outside_mm[here] = along[here], outside[here]
    return match


def gate_mm(piece: Piece, widest_mm: float) -> float:
    """Return the gate, narrower where two sides that look the same way lie close together."""
    return min(widest_mm, _GATE_OF_STEP * _least_step_mm(piece))


@lru_cache(maxsize=4)
def _least_step_mm(piece: Piece) -> float:
    straight = [face for face in piece.faces if face.centre_mm is None]
    steps = [
        abs(float(one.place(other.start_mm[None])[1][0]))
        for place, one in enumerate(straight)
        for other in straight[place + 1 :]
        if float(one.normal @ other.normal) > _ALIKE
    ]
    return min((step for step in steps if step > _NO_STEP_MM), default=np.inf)


def settled(pose: PiecePose, place_mm: FloatArray, normal: FloatArray, piece: Piece) -> PiecePose:
    """Refine a pose to the points near the profile, large residuals counting less."""
    for widest in _GATES_MM:
        points, out = pose.to_piece(place_mm), normal @ pose.turn
        match = matched(points, out, piece, gate_mm(piece, widest))
        on = match.face >= 0
        if on.sum() < MIN_POINTS:
            return pose
        middle = points[on].mean(axis=0)
        arm, n, rest = points[on] - middle, match.normal[on], match.outside_mm[on]
        design = np.column_stack([n, n[:, 1] * arm[:, 0] - n[:, 0] * arm[:, 1]])
        usual = _USUAL_SIGMAS * max(1.4826 * float(np.median(np.abs(rest))), 1e-3)
        weight = 1.0 / np.hypot(1.0, rest / usual)
        stiff = _STIFFNESS * len(rest) * np.diag([1.0, 1.0, piece.size_mm**2])
        step = np.linalg.solve((design.T * weight) @ design + stiff, -(design.T * weight) @ rest)
        pose = pose.moved(step[:2], float(step[2]), middle)
    return pose


def explained_mm(pose: PiecePose, place_mm: FloatArray, normal: FloatArray, piece: Piece) -> float:
    """Return the length of profile that has points on it, those far out counting less."""
    gate = gate_mm(piece, GATE_MM)
    match = matched(pose.to_piece(place_mm), normal @ pose.turn, piece, gate)
    on = np.flatnonzero(match.face >= 0)
    nearness = 1.0 - (match.outside_mm[on] / gate) ** 2
    cell = match.face[on] * 100000 + np.floor(match.along_mm[on]).astype(np.int64)
    _, inverse, count = np.unique(cell, return_inverse=True, return_counts=True)
    return float((np.bincount(inverse, nearness) / count).sum()) if len(on) else 0.0
