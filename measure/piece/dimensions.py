"""What the points on a piece say of its dimensions: each a linear estimate from the residuals."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.piece.face import PieceFace
from measure.piece.fit import LaidPiece
from measure.placing.pieces import MIN_PIECE

BIN_MM = 5.0
"""Length of the parts of profile whose mean is held against the certificate."""
_PARALLEL = np.sin(np.radians(0.1))
_CROSSING = np.sin(np.radians(15.0))
_WIDEST_ARC_RAD = np.radians(60.0)
# An eigenvalue this small beside the largest: the points do not tell this combination.
_SINGULAR = 1e-5
_BEND_SHARE = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class Dimension:
    """One dimension of the piece as one picture shows it.

    Attributes
    ----------
    name
        Which it is, the same in every picture.
    certified_mm
        Its certified value.
    off_mm
        Found less certified.
    noise_mm
        Standard deviation by the points, afresh with every placement.
    by_sensor_mm
        Shape (13,): change by the sensor's parameters, the same in every picture.
    bend_mm
        Standard deviation by what blur does on round sides.
    """

    name: str
    certified_mm: float
    off_mm: float
    noise_mm: float
    by_sensor_mm: FloatArray
    bend_mm: float


def dimensions_of(laid: LaidPiece) -> list[Dimension]:
    """Return the dimensions that the points tell: heights, widths, angles, radii, and the size."""
    return [
        *_between_parallels(laid),
        *_between_corners(laid),
        *_angles(laid),
        *_radii(laid),
        *_size(laid),
    ]


def form_of(laid: LaidPiece) -> list[Dimension]:
    """Return the mean distance from the certified profile of each part of it, rigidly laid."""
    rigid = _rigid(laid)
    weight = 1.0 / laid.sigma_mm**2
    # What the fit of the pose takes of each residual.
    normal = (rigid.T * weight) @ rigid
    solve = np.linalg.pinv(normal, rcond=_SINGULAR, hermitian=True) @ (rigid.T * weight)
    parts = []
    for index, face in enumerate(laid.piece.faces):
        before = sum(one.length_mm for one in laid.piece.faces[:index])
        count = max(1, round(face.length_mm / BIN_MM))
        cell = np.floor(laid.along_mm * count / face.length_mm).astype(np.int64)
        for part in range(count):
            here = (laid.face == index) & (cell == part)
            if here.sum() < MIN_PIECE:
                continue
            mean = np.where(here, weight, 0.0) / weight[here].sum()
            gradient = mean - (mean @ rigid) @ solve
            place = before + (part + 0.5) * face.length_mm / count
            parts.append(_told(f"profile at {place:.1f}", place, gradient, laid))
    return parts


def _told(name: str, certified_mm: float, gradient: FloatArray, laid: LaidPiece) -> Dimension:
    return Dimension(
        name=name,
        certified_mm=certified_mm,
        off_mm=float(gradient @ laid.outside_mm),
        noise_mm=float(np.linalg.norm(gradient * laid.sigma_mm)),
        by_sensor_mm=gradient @ laid.by_sensor_mm,
        bend_mm=_BEND_SHARE * abs(float(gradient @ laid.bend_mm)),
    )


def _rigid(laid: LaidPiece) -> FloatArray:
    """Return what shifts and a turn (per piece size) do to the distances, shape (N, 3)."""
    return np.column_stack([laid.normal, laid.turning_mm / laid.piece.size_mm])


def _gradient_of(columns: FloatArray, wanted: FloatArray, laid: LaidPiece) -> FloatArray | None:
    """Return the gradient of a combination of the columns' factors; None if it is not told.

    Parameters
    ----------
    columns
        Shape (N, K), effects on the distances; what they owe to the pose is taken off beside.
    wanted
        Shape (K,), the combination.
    laid
        The points.
    """
    columns = np.column_stack([columns, _rigid(laid)])
    wanted = np.concatenate([wanted, np.zeros(3)])
    weight = 1.0 / laid.sigma_mm**2
    information = (columns.T * weight) @ columns
    scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    told = values > _SINGULAR * values[-1]
    turned = vectors.T @ (wanted / scale)
    if not np.abs(turned[~told]).max(initial=0.0) <= 1e-6 * np.linalg.norm(turned):
        return None
    solution = vectors[:, told] @ (turned[told] / values[told]) / scale
    return np.asarray(weight * (columns @ solution))


def _between_parallels(laid: LaidPiece) -> Iterator[Dimension]:
    """Yield distances of neighbouring levels of parallel straight sides, and of the outermost."""
    for group in _parallel_groups(laid):
        ends = {(group[0], group[-1])} if len(group) > 2 else set()
        for one, other in sorted({*zip(group, group[1:], strict=False), *ends}):
            dimension = _height(laid, *sorted((one, other)))
            if dimension is not None:
                yield dimension


def _parallel_groups(laid: LaidPiece) -> list[list[int]]:
    """Return straight sides that were seen, those parallel together, sorted by level."""
    faces = laid.piece.faces
    groups: list[list[int]] = []
    for index in _straight_seen(laid):
        for group in groups:
            first = faces[group[0]]
            if abs(float(np.linalg.det([first.tangent, faces[index].tangent]))) < _PARALLEL:
                group.append(index)
                break
        else:
            groups.append([index])
    for group in groups:
        normal = faces[group[0]].normal
        level = [float(normal @ faces[index].start_mm) for index in group]
        group[:] = [group[place] for place in np.argsort(level, kind="stable")]
    return groups


def _straight_seen(laid: LaidPiece) -> list[int]:
    return [
        index
        for index, face in enumerate(laid.piece.faces)
        if face.centre_mm is None and (laid.face == index).sum() >= MIN_PIECE
    ]


def _height(laid: LaidPiece, one: int, other: int) -> Dimension | None:
    """Return the distance of two parallel sides, their direction by all of the piece."""
    first, second = laid.piece.faces[one], laid.piece.faces[other]
    # Along the normal of the first; the second's points out the same way, or against it.
    apart = float(first.normal @ (second.start_mm - first.start_mm))
    same = float(np.sign(first.normal @ second.normal))
    sign = -1.0 if apart < 0.0 else 1.0
    gradient = _gradient_of(_moving(laid, [one, other]), sign * np.array([-1.0, same]), laid)
    if gradient is None:
        return None
    what = "height" if same > 0.0 else "width"
    return _told(f"{what} {one + 1}-{other + 1}", abs(apart), gradient, laid)


def _moving(laid: LaidPiece, sides: Sequence[int]) -> FloatArray:
    """Return what each of some sides, moved out of the metal, does to the distances."""
    return np.asarray(laid.face[:, None] == np.array(sides), dtype=np.float64)


def _between_corners(laid: LaidPiece) -> Iterator[Dimension]:
    """Yield distances of neighbouring corners, and of the outermost.

    A corner is where two straight sides cross; the edge itself is not looked at.
    """
    seen = _straight_seen(laid)
    faces = laid.piece.faces
    corners = [
        index
        for index in seen
        if index + 1 in seen
        and abs(float(np.linalg.det([faces[index].tangent, faces[index + 1].tangent]))) > _CROSSING
    ]
    pairs = {*zip(corners, corners[1:], strict=False)}
    if len(corners) > 2:
        pairs.add((corners[0], corners[-1]))
    for one, other in sorted(pairs):
        dimension = _width(laid, one, other)
        if dimension is not None:
            yield dimension


def _width(laid: LaidPiece, one: int, other: int) -> Dimension | None:
    """Return the distance of the corners at the ends of two sides."""
    step = laid.piece.faces[other].end_mm - laid.piece.faces[one].end_mm
    distance = float(np.linalg.norm(step))
    sides = sorted({one, one + 1, other, other + 1})
    wanted = np.zeros(len(sides))
    for corner, sign in ((one, -1.0), (other, 1.0)):
        pair = laid.piece.faces[corner : corner + 2]
        normals = np.stack([face.normal for face in pair])
        share = np.linalg.solve(normals.T, step / distance)
        for side, part in zip((corner, corner + 1), share, strict=True):
            wanted[sides.index(side)] += sign * part
    gradient = _gradient_of(_moving(laid, sides), wanted, laid)
    if gradient is None:
        return None
    return _told(f"corner {one + 1}-{other + 1}", distance, gradient, laid)


def _angles(laid: LaidPiece) -> Iterator[Dimension]:
    """Yield the angles of straight sides with the next: what the end of the shorter is off, mm."""
    seen = _straight_seen(laid)
    faces = laid.piece.faces
    for one, other in zip(seen, seen[1:], strict=False):
        if abs(float(np.linalg.det([faces[one].tangent, faces[other].tangent]))) < _CROSSING:
            continue
        arm = min(faces[one].length_mm, faces[other].length_mm)
        moving = _moving(laid, [one, other])
        columns = np.column_stack([moving, moving * (laid.along_mm / arm)[:, None]])
        gradient = _gradient_of(columns, np.array([0.0, 0.0, -1.0, 1.0]), laid)
        if gradient is not None:
            yield _told(f"angle {one + 1}-{other + 1}", 0.0, gradient, laid)


def _radii(laid: LaidPiece) -> Iterator[Dimension]:
    """Yield radii of the round sides of which enough is seen."""
    for index, face in enumerate(laid.piece.faces):
        if face.centre_mm is None or laid.seen_mm[index] < _WIDEST_ARC_RAD * face.radius_mm:
            continue
        on = (laid.face == index)[:, None]
        columns = np.where(on, np.column_stack([laid.normal, np.ones(len(laid))]), 0.0)
        gradient = _gradient_of(columns, np.array([0.0, 0.0, 1.0]), laid)
        if gradient is not None:
            yield _told(f"radius {index + 1}", face.radius_mm, face.side * gradient, laid)


def _size(laid: LaidPiece) -> Iterator[Dimension]:
    """Yield the size of all that is seen, every point taken: the scale of the sensor."""
    arm = laid.points_mm - laid.points_mm.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(laid.points_mm, axis=0)))
    growing = (arm * laid.normal).sum(axis=1) / size
    gradient = _gradient_of(growing[:, None], np.ones(1), laid)
    if gradient is not None:
        yield _told("size", size, gradient, laid)


def hidden_faces(laid: LaidPiece) -> list[int]:
    """Return the sides that face the camera, and of whose inner part less than half is seen."""
    # The sheet's origin is the camera's foot on it.
    camera = laid.pose.to_piece(np.zeros((1, 2)))[0]
    return [
        index
        for index, face in enumerate(laid.piece.faces)
        if _faces(face, camera) and laid.seen_mm[index] < 0.5 * _inner_mm(face)
    ]


def _faces(face: PieceFace, camera_mm: FloatArray) -> bool:
    point, normal = face.points(np.array([0.5 * face.length_mm]))
    sight = camera_mm - point[0]
    return bool(normal[0] @ sight > np.cos(np.radians(70.0)) * np.linalg.norm(sight))


def _inner_mm(face: PieceFace) -> float:
    return max(0.0, face.length_mm - 4.0)
