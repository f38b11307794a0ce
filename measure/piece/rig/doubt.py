"""What a rig found from a piece is in doubt of: by the points, by the sensors, by the piece."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray, LaserSensor, LightPlane, RigidTransform
from measure.gauging.uncertainty import COVERAGE_FACTOR
from measure.piece.certified import Piece
from measure.piece.gradient import BEND_SHARE
from measure.piece.rig.bundle import Bundle
from measure.piece.rig.contact import mean_square_direction, pivot_of, touch
from measure.piece.rig.prisms import Known, normal_equations

_OWN = 13


@dataclass(frozen=True, slots=True, eq=False)
class Doubt:
    """What is not known of the free sensors' poses.

    Attributes
    ----------
    information
        Shape (6 F, 6 F): what the points tell, without what was known beforehand.
    by_chance
        Shape (6 F, 6 F): covariance by the points, with what was known.
    by_sensors
        Shape (6 F, 13 K): change of the poses by the sensors' own parameters.
    by_piece
        Shape (6 F, C): change for one sigma of each of the piece's own errors.
    """

    information: FloatArray
    by_chance: FloatArray
    by_sensors: FloatArray
    by_piece: FloatArray

    def covariance(self, of_sensors: FloatArray) -> FloatArray:
        """Return the covariance of the poses, shape (6 F, 6 F), given that of the sensors."""
        own = self.by_sensors @ of_sensors @ self.by_sensors.T
        return np.asarray(self.by_chance + own + self.by_piece @ self.by_piece.T)


def doubt_of(
    bundle: Bundle,
    sensors: Sequence[LaserSensor],
    piece: Piece,
    *,
    free: Sequence[int],
    known: Known,
    stretch_u95: float,
) -> Doubt:
    r"""Return what is not known of the poses that a bundle found.

    Notes
    -----
    The sensors stay as they were calibrated: with the normal equations N of the poses and the
    derivative :math:`J_c` of the distances by anything else, the poses are off by
    :math:`-N^{-1} J^T W J_c` times what that is off.
    """
    placings, cameras = bundle.placings, bundle.cameras
    normal = normal_equations(placings, cameras, piece, free, known)
    size, own = 6 * len(free), _OWN * len(sensors)
    causes = own + len(piece.faces) + 2
    total = np.zeros((size, causes))
    for index, (placing, fits) in enumerate(zip(placings, bundle.fits, strict=True)):
        of_pose = np.zeros((5, causes))
        for fit in fits:
            contact = fit.contact
            seen = touch(contact, cameras[contact.sensor], placing.rig_from_piece, piece)
            out_in_cam = seen.normal_in_rig @ cameras[contact.sensor].rotation
            by_cause = np.zeros((len(contact.face), causes))
            at = _OWN * contact.sensor
            by_cause[:, at : at + _OWN] = np.einsum("ni,nik->nk", out_in_cam, fit.sheet.by_sensor)
            by_cause[:, own:-2] = _by_faces(contact.face, piece)
            arm = seen.section_mm - pivot_of(piece)
            by_cause[:, -2] = (arm * seen.normal).sum(axis=1) * stretch_u95 / COVERAGE_FACTOR
            by_cause[:, -1] = BEND_SHARE * (fit.sheet.bend_mm * out_in_cam).sum(axis=1)
            weighted = contact.weight[:, None] ** 2 * by_cause
            of_pose += seen.by_pose.T @ weighted
            if contact.sensor in free:
                here = 6 * free.index(contact.sensor)
                total[here : here + 6] += seen.by_rig.T @ weighted
        total -= normal.coupling[index].T @ scaled_inverse(normal.own[index]) @ of_pose
    reduced = normal.reduced()
    inverse = scaled_inverse(reduced)
    gain = -inverse @ total
    return Doubt(reduced - known.of(free), inverse, gain[:, :own], gain[:, own:])


def _by_faces(face: IntArray, piece: Piece) -> FloatArray:
    """Return what one sigma of each side's place does: two sides' distance has the u95."""
    sigma_mm = piece.u95_mm / COVERAGE_FACTOR / np.sqrt(2.0)
    return np.asarray(sigma_mm * (face[:, None] == np.arange(len(piece.faces))))


def scaled_inverse(matrix: FloatArray) -> FloatArray:
    """Return the inverse of a positive matrix whose entries differ by many orders."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
    both = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(matrix / both, rcond=1e-13, hermitian=True) / both)


@dataclass(frozen=True, slots=True, eq=False)
class Workplace:
    """Where a sensor of the rig looks at the piece: motions are told as they show there.

    Attributes
    ----------
    from_step
        Shape (6, 6): from a step of the sensor's pose to its shifts along `axes` there (mm), and
        its turns about them (mm at half the piece's size).
    axes
        Shape (3, 3), rows, rig frame: the mean x, length and z of the piece.
    """

    from_step: FloatArray
    axes: FloatArray

    @classmethod
    def of(cls, bundle: Bundle, sensor: int, piece: Piece) -> "Workplace":
        """Take it from all placings that a sensor saw."""
        points, poses = [], []
        for placing in bundle.placings:
            for contact in placing.contacts:
                if contact.sensor == sensor:
                    points.append(contact.in_cam_mm.mean(axis=0))
                    poses.append(placing.rig_from_piece.rotation)
        pose = bundle.cameras[sensor]
        middle = pose.apply(np.mean(points, axis=0)[None])[0]
        length, _ = mean_square_direction([one[:, 1] for one in poses])
        z = poses[0][:, 2] - (poses[0][:, 2] @ length) * length
        z /= np.linalg.norm(z)
        axes = np.stack([np.cross(length, z), length, z])
        x, y, w = middle - pose.translation_mm
        # What a turn about the camera's centre shifts there: omega x arm.
        shifting = np.array([[0.0, w, -y], [-w, 0.0, x], [y, -x, 0.0]])
        arm = 0.5 * piece.size_mm
        from_step = np.block([[axes @ shifting, axes], [arm * axes, np.zeros((3, 3))]])
        return cls(from_step, axes)


def mirrored(
    cameras: Sequence[RigidTransform], planes: Sequence[LightPlane], sensor: int, anchor: int
) -> RigidTransform:
    """Return the pose of a sensor in the rig's mirror image in the sheet of the anchor.

    The mirror image shows the same sections: a picture of a section knows not from which side
    of the sheet it was taken.
    """
    of_anchor, of_sensor = _reflection(planes[anchor]), _reflection(planes[sensor])
    there = np.eye(4)
    relative = cameras[anchor].inverse() @ cameras[sensor]
    there[:3, :3], there[:3, 3] = relative.rotation, relative.translation_mm
    twin = of_anchor @ there @ of_sensor
    return cameras[anchor] @ RigidTransform(twin[:3, :3], twin[:3, 3])


def _reflection(plane: LightPlane) -> FloatArray:
    normal = plane.normal_in_cam
    matrix = np.eye(4)
    matrix[:3, :3] -= 2.0 * np.outer(normal, normal)
    matrix[:3, 3] = -2.0 * plane.offset_mm * normal
    return matrix
