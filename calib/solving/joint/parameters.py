"""The unknowns of a solve: what they are, how a step moves them, how they map to the sensor's.

This file owns the order of the parameter vector. The *global* block holds the free parameters of
the camera, then (where the plane is solved) two angles of its normal and its offset; each view
has a block of six: a small rotation, applied from the left, and a shift, both in the camera frame.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.arrays import FloatArray
from calib.camera import PARAMETERS, CameraModel
from calib.plane import LightPlane
from calib.rigid import RigidTransform

POSE_SIZE = 6
PLANE_SIZE = 3


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A state of a solve: camera, light plane, poses. It is not checked: a solver may try any.

    Attributes
    ----------
    camera
        Shape (9,), in the order of `calib.camera.PARAMETERS`.
    normal, offset_mm
        The light plane ``normal @ p + offset_mm = 0`` in the camera frame; unit normal, shape (3,).
    rotation, translation_mm
        cam_from_board of each view, shapes (M, 3, 3) and (M, 3).
    """

    camera: FloatArray
    normal: FloatArray
    offset_mm: float
    rotation: FloatArray
    translation_mm: FloatArray

    @classmethod
    def start(
        cls, camera: CameraModel, plane: LightPlane | None, poses: list[RigidTransform]
    ) -> "Estimate":
        """Make a state of values; without a plane, any stands in its place and is not used."""
        return cls(
            camera=camera.parameters,
            normal=np.array([0.0, 0.0, -1.0]) if plane is None else plane.normal_in_cam,
            offset_mm=1.0 if plane is None else plane.offset_mm,
            rotation=np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3),
            translation_mm=np.array([pose.translation_mm for pose in poses]).reshape(-1, 3),
        )

    @property
    def poses(self) -> list[RigidTransform]:
        """cam_from_board of each view."""
        return [
            RigidTransform(rotation, translation)
            for rotation, translation in zip(self.rotation, self.translation_mm, strict=True)
        ]

    @property
    def plane(self) -> LightPlane:
        """The light plane, its normal turned towards the camera."""
        return LightPlane.from_coefficients(np.append(self.normal, self.offset_mm))


@dataclass(frozen=True, slots=True)
class Layout:
    """Which global parameters are free.

    Attributes
    ----------
    camera
        Indices into `PARAMETERS` of the free ones, ascending.
    plane
        Whether the light plane is free.
    """

    camera: tuple[int, ...]
    plane: bool

    @property
    def size(self) -> int:
        """Number of global parameters."""
        return len(self.camera) + (PLANE_SIZE if self.plane else 0)

    @property
    def camera_columns(self) -> slice:
        """Columns of the camera in the global block."""
        return slice(0, len(self.camera))

    @property
    def plane_columns(self) -> slice:
        """Columns of the plane in the global block."""
        return slice(len(self.camera), self.size)

    def moved(
        self, estimate: Estimate, global_step: FloatArray, pose_steps: FloatArray
    ) -> Estimate:
        """Return the state a step away; shapes (size,) and (M, 6)."""
        camera = estimate.camera.copy()
        camera[list(self.camera)] += global_step[self.camera_columns]
        turns = Rotation.from_rotvec(pose_steps[:, :3]).as_matrix()
        moved = replace(
            estimate,
            camera=camera,
            rotation=orthonormal(turns @ estimate.rotation),
            translation_mm=estimate.translation_mm + pose_steps[:, 3:],
        )
        if not self.plane:
            return moved
        angles = global_step[self.plane_columns]
        normal = estimate.normal + tangent_basis(estimate.normal) @ angles[:2]
        return replace(
            moved,
            normal=normal / np.linalg.norm(normal),
            offset_mm=estimate.offset_mm + float(angles[2]),
        )

    def sensor_from_global(self, estimate: Estimate) -> FloatArray:
        """Return d(sensor parameters)/d(global parameters), shape (13, size).

        The sensor's (a, b, c, d) have d >= 0, the state's need not: the sign is turned here.
        """
        jacobian = np.zeros((len(PARAMETERS) + 4, self.size))
        jacobian[list(self.camera), range(len(self.camera))] = 1.0
        if self.plane:
            sign = -1.0 if estimate.offset_mm < 0.0 else 1.0
            block = jacobian[len(PARAMETERS) :, self.plane_columns]
            block[:3, :2] = sign * tangent_basis(estimate.normal)
            block[3, 2] = sign
        return jacobian


def tangent_basis(normal: FloatArray) -> FloatArray:
    """Return two unit directions across a unit normal, shape (3, 2), always the same for it."""
    axis = np.zeros(3)
    axis[np.argmin(np.abs(normal))] = 1.0
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first)])


def orthonormal(rotations: FloatArray) -> FloatArray:
    """Take the rounding of many products out of nearly orthonormal matrices, shape (M, 3, 3)."""
    # One Newton step towards the polar factor squares an error that is 1e-15 a product.
    gram = rotations.transpose(0, 2, 1) @ rotations
    return np.asarray(rotations @ (1.5 * np.eye(3) - 0.5 * gram))
