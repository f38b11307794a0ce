"""Where each sensor sees the piece by itself, and the placing in which these agree."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform, SheetFrame, StripePoints
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece
from measure.piece.fit import hanging_together, poses_on_sheet
from measure.piece.match import GATE_MM, gate_mm, matched
from measure.piece.rig.contact import Contact, mean_square_direction, pivot_of, section_of
from measure.piece.rig.prisms import Placing
from measure.piece.search import PiecePose

_LIKELY = 0.6
# Until the scatter of the points is known they count alike.
_FIRST_SIGMA_MM = 0.02
_USUAL_SIGMAS = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """What one sensor shows of the piece in one placing.

    Attributes
    ----------
    sensor
        Its place in the rig.
    sheet
        All points that hang together.
    poses
        cam_from_piece, as if the piece stood square to the sheet, and the length of profile that
        each explains; the best first.
    """

    sensor: int
    sheet: SheetPoints
    poses: tuple[tuple[RigidTransform, float], ...]


def sight(stripe: StripePoints, index: int, sensor: LaserSensor, piece: Piece) -> Sighting | str:
    """Find the piece in the picture of one sensor of a rig, or return why it cannot be."""
    sheet = hanging_together(stripe, sensor)
    if isinstance(sheet, str):
        return sheet
    found = poses_on_sheet(sheet, sensor, piece)
    if not found:
        return f"no piece: nothing in the picture has the profile of {piece.name}"
    frame = SheetFrame.of(sensor.plane)
    likely = [(pose, length) for pose, length in found if length >= _LIKELY * found[0][1]]
    return Sighting(
        index, sheet, tuple((_in_space(pose, frame), length) for pose, length in likely)
    )


def _in_space(pose: PiecePose, frame: SheetFrame) -> RigidTransform:
    """Return cam_from_piece of a piece that stands square to the sheet."""
    x, z = pose.turn.T @ frame.axes_in_cam
    rotation = np.column_stack([x, np.cross(z, x), z])
    return RigidTransform(rotation, frame.points(pose.shift_mm))


def first_placing(
    sightings: Sequence[Sighting],
    sensors: Sequence[LaserSensor],
    cameras: Sequence[RigidTransform],
    piece: Piece,
) -> Placing:
    """Return the placing that agrees best with where each sensor sees the piece by itself.

    Its points are on the sides that each sensor's own pose gives them.
    """
    normals = [
        cameras[one.sensor].rotation @ sensors[one.sensor].plane.normal_in_cam for one in sightings
    ]
    square, apart_rad = mean_square_direction(normals)
    if piece.length_in_rig is not None:
        square, apart_rad = np.array(piece.length_in_rig), 0.0
        square = square / np.linalg.norm(square)
    chosen = max(
        product(*(one.poses for one in sightings)),
        key=lambda poses: _agreement(sightings, poses, cameras, square, piece),
    )
    contacts = [
        given_sides(one, pose.inverse(), piece, GATE_MM)
        for one, (pose, _) in zip(sightings, chosen, strict=True)
    ]
    best = int(np.argmax([length for _, length in chosen]))
    pose = cameras[sightings[best].sensor] @ chosen[best][0]
    return Placing(
        tuple(contacts),
        with_length_along(pose, square, piece),
        square,
        float(np.hypot(piece.squareness_rad, apart_rad)),
    )


def _agreement(
    sightings: Sequence[Sighting],
    poses: Sequence[tuple[RigidTransform, float]],
    cameras: Sequence[RigidTransform],
    square: FloatArray,
    piece: Piece,
) -> float:
    """Return how much is explained, less how far apart the sensors see the piece's edges."""
    corners = np.insert(piece.corners_mm, 1, 0.0, axis=1)
    explained = sum(
        length / one.poses[0][1] for one, (_, length) in zip(sightings, poses, strict=True)
    )
    placed = [
        (cameras[one.sensor] @ pose).apply(corners)
        for one, (pose, _) in zip(sightings, poses, strict=True)
    ]
    off = [np.cross(one - placed[0], square) for one in placed[1:]]
    apart = sum(float(np.linalg.norm(one, axis=1).mean()) for one in off)
    return explained - apart / piece.size_mm


def with_length_along(
    rig_from_piece: RigidTransform, direction: FloatArray, piece: Piece
) -> RigidTransform:
    """Turn a pose, about the middle of its edges, so that its length points along a direction."""
    length = rig_from_piece.rotation[:, 1]
    towards = direction * (1.0 if direction @ length >= 0.0 else -1.0)
    axis = np.cross(length, towards)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return rig_from_piece
    turn = RigidTransform.from_rotation_vector(
        axis * (np.arcsin(min(sine, 1.0)) / sine), np.zeros(3)
    )
    pivot = rig_from_piece.apply(np.insert(pivot_of(piece), 1, 0.0)[None])[0]
    about = RigidTransform(turn.rotation, pivot - turn.rotation @ pivot)
    return about @ rig_from_piece


def given_sides(
    sighting: Sighting, piece_from_camera: RigidTransform, piece: Piece, widest_mm: float
) -> Contact:
    """Give the points near the profile their sides; those far out count less."""
    section, _, normal = section_of(sighting.sheet, piece_from_camera)
    match = matched(section, normal, piece, gate_mm(piece, widest_mm))
    on = np.flatnonzero(match.face >= 0)
    off = match.outside_mm[on]
    spread = _USUAL_SIGMAS * max(1.4826 * float(np.median(np.abs(off))) if len(on) else 0.0, 1e-3)
    weight = 1.0 / np.hypot(1.0, off / spread) ** 0.5 / _FIRST_SIGMA_MM
    return Contact(sighting.sensor, sighting.sheet.points_in_cam_mm[on], match.face[on], weight)
