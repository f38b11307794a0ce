"""Points of several sensors on one prism in space: their distances, and what motions do to them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from calib import BoolArray, FloatArray, IntArray, RigidTransform
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece

POSE_PARAMETERS = 5
"""Of a prism: shifts along its x and z, turns about its y, x and z. Along y it is the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """The points of one sensor on the piece in one placing.

    Attributes
    ----------
    sensor
        Its place in the rig.
    in_cam_mm
        Shape (N, 3), camera frame.
    face
        Shape (N,), index of the side of each.
    weight
        Shape (N,), 1 / mm: one over its standard deviation.
    """

    sensor: int
    in_cam_mm: FloatArray
    face: IntArray
    weight: FloatArray

    def weighted(self, weight: FloatArray) -> "Contact":
        """Return the same points, counting otherwise."""
        return replace(self, weight=weight)


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """How points lie on the piece, and what moves them on it.

    Attributes
    ----------
    outside_mm
        Shape (N,), how far out of the profile.
    section_mm, normal
        Shape (N, 2), in the piece's x and z: the point, and the direction out of the metal.
    length_mm
        Shape (N,), its y in the piece's frame.
    normal_in_rig
        Shape (N, 3).
    by_pose
        Shape (N, 5): change of `outside_mm` when the points move in the piece's frame, in the
        order of `POSE_PARAMETERS`, turns about `pivot_of` the piece.
    by_rig
        Shape (N, 6): change by the sensor's pose in the rig, in the order of
        `calib.POSE_PARAMETERS`.
    """

    outside_mm: FloatArray
    section_mm: FloatArray
    normal: FloatArray
    length_mm: FloatArray
    normal_in_rig: FloatArray
    by_pose: FloatArray
    by_rig: FloatArray


def touch(
    contact: Contact, rig_from_camera: RigidTransform, rig_from_piece: RigidTransform, piece: Piece
) -> Touch:
    """Lay points on the sides that they belong to, however far along these they lie."""
    arm_mm = contact.in_cam_mm @ rig_from_camera.rotation.T
    in_piece = rig_from_piece.inverse().apply(arm_mm + rig_from_camera.translation_mm)
    section = in_piece[:, [0, 2]]
    outside, normal = _off_sides(section, contact.face, piece)
    (x, z), y = (section - pivot_of(piece)).T, in_piece[:, 1]
    n_x, n_z = normal.T
    normal_in_rig = normal @ rig_from_piece.rotation[:, [0, 2]].T
    return Touch(
        outside_mm=outside,
        section_mm=section,
        normal=normal,
        length_mm=y,
        normal_in_rig=normal_in_rig,
        by_pose=np.column_stack([n_x, n_z, n_x * z - n_z * x, n_z * y, -n_x * y]),
        by_rig=np.column_stack([np.cross(arm_mm, normal_in_rig), normal_in_rig]),
    )


def _off_sides(
    section_mm: FloatArray, face: IntArray, piece: Piece
) -> tuple[FloatArray, FloatArray]:
    """Return how far out of its side each point lies, (N,), and the direction, (N, 2)."""
    start, normals, is_round = _sides(piece)
    normal = normals[face]
    outside = ((section_mm - start[face]) * normal).sum(axis=1)
    for index in np.flatnonzero(is_round):
        on = face == index
        along, outside[on] = piece.faces[index].place(section_mm[on])
        normal[on] = piece.faces[index].points(along)[1]
    return outside, normal


@lru_cache(maxsize=4)
def _sides(piece: Piece) -> tuple[FloatArray, FloatArray, BoolArray]:
    return (
        np.stack([face.start_mm for face in piece.faces]),
        np.stack([face.normal for face in piece.faces]),
        np.array([face.centre_mm is not None for face in piece.faces]),
    )


def pivot_of(piece: Piece) -> FloatArray:
    """Return the place in its section about which a piece is turned, shape (2,)."""
    return np.asarray(piece.corners_mm.mean(axis=0))


def stepped(rig_from_piece: RigidTransform, step: FloatArray, piece: Piece) -> RigidTransform:
    """Return the pose by which points lie moved on the piece by a step of `POSE_PARAMETERS`."""
    x, z, about_y, about_x, about_z = step
    pivot = np.array([pivot_of(piece)[0], 0.0, pivot_of(piece)[1]])
    turn = RigidTransform.from_rotation_vector([about_x, about_y, about_z], np.zeros(3)).rotation
    moved = RigidTransform(turn, pivot + [x, 0.0, z] - turn @ pivot)
    return rig_from_piece @ moved.inverse()


def section_of(
    sheet: SheetPoints, piece_from_camera: RigidTransform
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where points lie in the piece's section, how the stripe runs there, and their normals.

    Returns
    -------
    section_mm
        Shape (N, 2).
    along_mm
        Shape (N, 2): motion for one pixel along the stripe.
    normal
        Shape (N, 2), unit, towards the camera: only what faces it is seen.
    """
    rotation = piece_from_camera.rotation[[0, 2]]
    section = piece_from_camera.apply(sheet.points_in_cam_mm)[:, [0, 2]]
    along = sheet.along_mm @ rotation.T
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    sight = piece_from_camera.translation_mm[[0, 2]] - section
    away = (normal * sight).sum(axis=1) < 0.0
    return section, along, normal * np.where(away, -1.0, 1.0)[:, None]


def mean_square_direction(directions: Sequence[FloatArray]) -> tuple[FloatArray, float]:
    """Return the mean of unit directions up to sign, and the largest angle from it, rad."""
    first = directions[0]
    alike = np.stack([one * np.sign(one @ first or 1.0) for one in directions])
    mean = alike.sum(axis=0)
    mean /= np.linalg.norm(mean)
    return mean, float(np.arccos(np.clip(alike @ mean, -1.0, 1.0)).max())
