"""Where in a picture a piece lies: pairs of points that fit pairs of its profile vote for poses."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from calib import FloatArray, IntArray
from measure.piece.certified import Piece

_STEP_MM = 1.0
# The pairs go by the square of it.
_MOST_SAMPLES = 250
_NEAR_MM = 1.5
# A normal that is off by this much is as strange as a length that is off by the above.
_NEAR_SINE = 0.15
_ALIKE = 0.9
_PAIRS = 300
_POSES = 1000
# Which of them are worth a look at all points, a few tell.
_ROUGHLY = 4
_LIKELY = 200
_REFINED = 6
_SAME_MM = 1.0
# A pair along one straight side fits everywhere along it, and along every other straight line.
_LEAST_RISE = 0.03
_CELL_MM = 0.5
_BATCH = 100
_LEAST_SHARE = 0.2
_LEAST_OF_BEST = 0.7
# Where few of the drawn pairs tell anything, more are drawn.
_DRAWS = (20, 200)


@dataclass(frozen=True, slots=True, eq=False)
class PiecePose:
    """How the piece lies on the sheet: ``(s, t) = turn @ (x, z) + shift_mm``.

    Attributes
    ----------
    turn
        Shape (2, 2), orthogonal; its determinant says from which end the piece is seen.
    shift_mm
        Shape (2,).
    """

    turn: FloatArray
    shift_mm: FloatArray

    def to_piece(self, sheet_mm: FloatArray) -> FloatArray:
        """Return points of the sheet in the piece's frame, shape (N, 2)."""
        return np.asarray((sheet_mm - self.shift_mm) @ self.turn)

    def moved(self, shift_mm: FloatArray, angle_rad: float, about_mm: FloatArray) -> "PiecePose":
        """Return the pose by which points lie turned about a place of the piece, then shifted."""
        cos, sin = np.cos(angle_rad), np.sin(angle_rad)
        extra = np.array([[cos, -sin], [sin, cos]])
        turn = self.turn @ extra.T
        # q = extra (p - about) + about + shift must be what the new pose gives.
        return PiecePose(turn, self.shift_mm + self.turn @ about_mm - turn @ (about_mm + shift_mm))


def find_piece(sheet_mm: FloatArray, normal: FloatArray, piece: Piece) -> list[PiecePose]:
    """Return the poses in which most of a piece is covered by points, the best first.

    Parameters
    ----------
    sheet_mm
        Shape (N, 2), on the sheet.
    normal
        Shape (N, 2), unit, out of what the points lie on.
    piece
        What is looked for.

    Returns
    -------
    poses
        To about a millimetre; none where nothing like the piece is there.

    Notes
    -----
    Points of clutter cost time only: a pose counts by how much of the profile it explains. Draws
    are seeded, so that the same picture is always judged alike.
    """
    index = _thinned(sheet_mm, normal)
    points, normals = sheet_mm[index], normal[index]
    rng = np.random.default_rng(0)
    poses: list[tuple[int, PiecePose]] = []
    for mirror in (1.0, -1.0):
        known = _Known.of(piece, mirror)
        seen = _pairs(points, normals, rng, piece.size_mm)
        turns, shifts = _aligned(seen, known, rng)
        rough = _scores(turns, shifts, points[::_ROUGHLY], normals[::_ROUGHLY], known)
        likely = np.argsort(-rough, kind="stable")[:_LIKELY]
        turns, shifts = turns[likely], shifts[likely]
        scores = _scores(turns, shifts, points, normals, known)
        for place in np.argsort(-scores, kind="stable")[: 8 * _REFINED]:
            pose = PiecePose(turns[place] * [mirror, 1.0], shifts[place])
            poses.append((int(scores[place]), pose))
    poses.sort(key=lambda one: -one[0])
    most = poses[0][0] if poses else 0
    enough = max(_LEAST_SHARE * len(known.outward), _LEAST_OF_BEST * most)
    return _distinct([pose for score, pose in poses if score >= enough], piece)


def _thinned(points_mm: FloatArray, normal: FloatArray) -> IntArray:
    """Return one point a millimetre and direction."""
    cell = np.column_stack([np.rint(points_mm / _STEP_MM), np.rint(2.0 * normal)]).astype(np.int64)
    return np.sort(np.unique(cell, axis=0, return_index=True)[1])


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Pairs of points: middle (K, 2), direction (K,), and what a motion does not change (K, 5)."""

    middle_mm: FloatArray
    angle_rad: FloatArray
    shape: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """Samples of a piece's profile, the same in every picture.

    Attributes
    ----------
    pairs, tree
        All pairs of samples, and their shapes to be looked up.
    outward
        Shape (M, 2), normals of the samples.
    low_mm, nearest
        Corner of a grid of cells about the profile, and the sample nearest to each; -1 where none
        is near, as in the outermost cells.
    """

    pairs: _Pairs
    tree: KDTree
    outward: FloatArray
    low_mm: FloatArray
    nearest: IntArray

    @staticmethod
    @lru_cache(maxsize=8)
    def of(piece: Piece, mirror: float) -> "_Known":
        """Sample a piece, seen from one end or, where `mirror` is -1, from the other."""
        profile, outward = piece.samples(max(_STEP_MM, piece.size_mm / _MOST_SAMPLES))
        profile, outward = profile * [mirror, 1.0], outward * [mirror, 1.0]
        low = profile.min(axis=0) - 2.0 * _NEAR_MM
        count = np.ceil((np.ptp(profile, axis=0) + 4.0 * _NEAR_MM) / _CELL_MM).astype(np.int64)
        cells = low + (np.indices(count).reshape(2, -1).T + 0.5) * _CELL_MM
        distance, nearest = KDTree(profile).query(cells, distance_upper_bound=_NEAR_MM)
        nearest = np.where(np.isfinite(distance), nearest, -1).reshape(count)
        pairs = _described(profile, outward, *np.nonzero(~np.eye(len(profile), dtype=bool)))
        return _Known(
            pairs,
            KDTree(pairs.shape),
            outward,
            low - _CELL_MM,
            np.pad(nearest, 1, constant_values=-1),
        )


def _described(points: FloatArray, normals: FloatArray, i: IntArray, j: IntArray) -> _Pairs:
    step = points[j] - points[i]
    length = np.linalg.norm(step, axis=1)
    along = step / length[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    scale = _NEAR_MM / _NEAR_SINE
    shape = [length]
    shape += [scale * (normals[k] * base).sum(axis=1) for k in (i, j) for base in (along, across)]
    return _Pairs(
        0.5 * (points[i] + points[j]), np.arctan2(step[:, 1], step[:, 0]), np.stack(shape, axis=1)
    )


def _pairs(
    points: FloatArray, normals: FloatArray, rng: np.random.Generator, size_mm: float
) -> _Pairs:
    """Draw pairs as far apart as they may be on the piece, not both on one line if possible."""
    for draws in _DRAWS:
        i, j = rng.integers(0, len(points), (2, draws * _PAIRS))
        step = points[j] - points[i]
        length = np.linalg.norm(step, axis=1)
        far = (length > 0.2 * size_mm) & (length < size_mm + _NEAR_MM)
        rise = np.maximum(np.abs((step * normals[i]).sum(1)), np.abs((step * normals[j]).sum(1)))
        telling = far & (rise > _LEAST_RISE * length)
        if telling.sum() >= _PAIRS:
            break
    chosen = np.flatnonzero(telling if telling.any() else far)[:_PAIRS]
    return _described(points, normals, i[chosen], j[chosen])


def _aligned(
    seen: _Pairs, known: _Known, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return turns (P, 2, 2) and shifts (P, 2) that bring known pairs onto seen ones like them."""
    if len(seen.middle_mm) == 0 or len(known.pairs.middle_mm) == 0:
        return np.empty((0, 2, 2)), np.empty((0, 2))
    near = KDTree(seen.shape).query_ball_tree(known.tree, _NEAR_MM)
    of_seen = np.repeat(np.arange(len(near)), [len(some) for some in near])
    of_known = np.array([one for some in near for one in some], dtype=np.int64)
    if len(of_seen) > _POSES:
        chosen = rng.choice(len(of_seen), _POSES, replace=False)
        of_seen, of_known = of_seen[chosen], of_known[chosen]
    angle = seen.angle_rad[of_seen] - known.pairs.angle_rad[of_known]
    cos, sin = np.cos(angle), np.sin(angle)
    turns = np.stack([np.stack([cos, -sin], 1), np.stack([sin, cos], 1)], axis=1)
    moved = (turns @ known.pairs.middle_mm[of_known][:, :, None])[:, :, 0]
    return turns, seen.middle_mm[of_seen] - moved


def _scores(
    turns: FloatArray, shifts: FloatArray, points: FloatArray, normals: FloatArray, known: _Known
) -> IntArray:
    """Return how many samples of the profile each pose explains, shape (P,)."""
    batches = np.array_split(np.arange(len(turns)), max(1, len(turns) // _BATCH))
    return np.concatenate([
        _explained(turns[some], shifts[some], points, normals, known) for some in batches
    ])


def _explained(
    turns: FloatArray, shifts: FloatArray, points: FloatArray, normals: FloatArray, known: _Known
) -> IntArray:
    """Return how many samples of the profile have a point of their direction beside them, (P,)."""
    placed = points @ turns - shifts[:, None] @ turns - known.low_mm
    last = np.array(known.nearest.shape) - 1
    cell = np.clip((placed / _CELL_MM).astype(np.int64), 0, last)
    near = known.nearest[cell[..., 0], cell[..., 1]]
    pose, point = np.nonzero(near >= 0)
    near = near[pose, point]
    same_way = ((normals @ turns)[pose, point] * known.outward[near]).sum(axis=1) > _ALIKE
    hit = np.zeros((len(turns), len(known.outward)), dtype=bool)
    hit[pose[same_way], near[same_way]] = True
    return np.asarray(hit.sum(axis=1), dtype=np.int64)


def _distinct(poses: list[PiecePose], piece: Piece) -> list[PiecePose]:
    """Return the first few that differ by more than what the fit that follows mends."""
    corners = piece.corners_mm
    kept: list[PiecePose] = []
    for pose in poses:
        placed = corners @ pose.turn.T + pose.shift_mm
        apart = [
            np.abs(placed - (corners @ one.turn.T + one.shift_mm)).max() > _SAME_MM for one in kept
        ]
        if all(apart):
            kept.append(pose)
        if len(kept) == _REFINED:
            break
    return kept
