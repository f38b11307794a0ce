"""What the points on a piece say of its dimensions: each a linear estimate from the residuals."""

from collections.abc import Iterator, Sequence

import numpy as np

from calib import FloatArray
from measure.piece.face import PieceFace
from measure.piece.gradient import Dimension, gradient_of, mean_gradients, told
from measure.piece.laid import LaidPoints
from measure.placing.pieces import MIN_PIECE

BIN_MM = 5.0
"""Length of the parts of profile whose mean is held against the certificate."""
_PARALLEL = np.sin(np.radians(0.1))
_CROSSING = np.sin(np.radians(15.0))
_WIDEST_ARC_RAD = np.radians(60.0)


def dimensions_of(laid: LaidPoints) -> list[Dimension]:
    """Return the dimensions that the points tell: heights, widths, angles, radii, and the size."""
    return [
        *_between_parallels(laid),
        *_between_corners(laid),
        *_angles(laid),
        *_radii(laid),
        *_size(laid),
    ]


def form_of(laid: LaidPoints) -> list[Dimension]:
    """Return the mean distance from the certified profile of each part of it, rigidly laid."""
    gradient_of_mean = mean_gradients(laid)
    parts = []
    for index, face in enumerate(laid.piece.faces):
        before = sum(one.length_mm for one in laid.piece.faces[:index])
        count = max(1, round(face.length_mm / BIN_MM))
        cell = np.floor(laid.along_mm * count / face.length_mm).astype(np.int64)
        for part in range(count):
            here = (laid.face == index) & (cell == part)
            if here.sum() < MIN_PIECE:
                continue
            place = before + (part + 0.5) * face.length_mm / count
            parts.append(told(f"profile at {place:.1f}", place, gradient_of_mean(here), laid))
    return parts


def _between_parallels(laid: LaidPoints) -> Iterator[Dimension]:
    """Yield distances of neighbouring levels of parallel straight sides, and of the outermost."""
    for group in _parallel_groups(laid):
        ends = {(group[0], group[-1])} if len(group) > 2 else set()
        for one, other in sorted({*zip(group, group[1:], strict=False), *ends}):
            dimension = _height(laid, *sorted((one, other)))
            if dimension is not None:
                yield dimension


def _parallel_groups(laid: LaidPoints) -> list[list[int]]:
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


def _straight_seen(laid: LaidPoints) -> list[int]:
    return [
        index
        for index, face in enumerate(laid.piece.faces)
        if face.centre_mm is None and (laid.face == index).sum() >= MIN_PIECE
    ]


def _height(laid: LaidPoints, one: int, other: int) -> Dimension | None:
    """Return the distance of two parallel sides, their direction by all of the piece."""
    first, second = laid.piece.faces[one], laid.piece.faces[other]
    # Along the normal of the first; the second's points out the same way, or against it.
    apart = float(first.normal @ (second.start_mm - first.start_mm))
    same = float(np.sign(first.normal @ second.normal))
    sign = -1.0 if apart < 0.0 else 1.0
    gradient = gradient_of(_moving(laid, [one, other]), sign * np.array([-1.0, same]), laid)
    if gradient is None:
        return None
    what = "height" if same > 0.0 else "width"
    return told(f"{what} {one + 1}-{other + 1}", abs(apart), gradient, laid)


def _moving(laid: LaidPoints, sides: Sequence[int]) -> FloatArray:
    """Return what each of some sides, moved out of the metal, does to the distances."""
    return np.asarray(laid.face[:, None] == np.array(sides), dtype=np.float64)


def _between_corners(laid: LaidPoints) -> Iterator[Dimension]:
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


def _width(laid: LaidPoints, one: int, other: int) -> Dimension | None:
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
    gradient = gradient_of(_moving(laid, sides), wanted, laid)
    if gradient is None:
        return None
    return told(f"corner {one + 1}-{other + 1}", distance, gradient, laid)


def _angles(laid: LaidPoints) -> Iterator[Dimension]:
    """Yield the angles of straight sides with the next: what the end of the shorter is off, mm."""
    seen = _straight_seen(laid)
    faces = laid.piece.faces
    for one, other in zip(seen, seen[1:], strict=False):
        if abs(float(np.linalg.det([faces[one].tangent, faces[other].tangent]))) < _CROSSING:
            continue
        arm = min(faces[one].length_mm, faces[other].length_mm)
        moving = _moving(laid, [one, other])
        columns = np.column_stack([moving, moving * (laid.along_mm / arm)[:, None]])
        gradient = gradient_of(columns, np.array([0.0, 0.0, -1.0, 1.0]), laid)
        if gradient is not None:
            yield told(f"angle {one + 1}-{other + 1}", 0.0, gradient, laid)


def _radii(laid: LaidPoints) -> Iterator[Dimension]:
    """Yield radii of the round sides of which enough is seen."""
    for index, face in enumerate(laid.piece.faces):
        if face.centre_mm is None or laid.seen_mm[index] < _WIDEST_ARC_RAD * face.radius_mm:
            continue
        on = (laid.face == index)[:, None]
        columns = np.where(on, np.column_stack([laid.normal, np.ones(len(laid))]), 0.0)
        gradient = gradient_of(columns, np.array([0.0, 0.0, face.side]), laid)
        if gradient is not None:
            yield told(f"radius {index + 1}", face.radius_mm, gradient, laid)


def _size(laid: LaidPoints) -> Iterator[Dimension]:
    """Yield the size of all that is seen, every point taken: the scale of the sensor."""
    arm = laid.points_mm - laid.points_mm.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(laid.points_mm, axis=0)))
    growing = (arm * laid.normal).sum(axis=1) / size
    gradient = gradient_of(growing[:, None], np.ones(1), laid)
    if gradient is not None:
        yield told("size", size, gradient, laid)


def hidden_faces(laid: LaidPoints, cameras_mm: FloatArray) -> list[int]:
    """Return the sides that face a camera, and of whose inner part less than half is seen.

    The cameras' places in the piece's frame have shape (K, 2).
    """
    return [
        index
        for index, face in enumerate(laid.piece.faces)
        if any(_faces(face, camera) for camera in cameras_mm)
        and laid.seen_mm[index] < 0.5 * _inner_mm(face)
    ]


def _faces(face: PieceFace, camera_mm: FloatArray) -> bool:
    point, normal = face.points(np.array([0.5 * face.length_mm]))
    sight = camera_mm - point[0]
    return bool(normal[0] @ sight > np.cos(np.radians(70.0)) * np.linalg.norm(sight))


def _inner_mm(face: PieceFace) -> float:
    return max(0.0, face.length_mm - 4.0)
