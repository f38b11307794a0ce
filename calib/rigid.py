"""Rigid motions between two frames."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from calib.arrays import FloatArray, frozen


@dataclass(frozen=True, slots=True, eq=False)
class RigidTransform:
    """The map ``p_in_a = rotation @ p_in_b + translation_mm``, named ``a_from_b``.

    Maps chain by ``a_from_b @ b_from_c``.

    Attributes
    ----------
    rotation
        Shape (3, 3), a proper rotation.
    translation_mm
        Shape (3,), the origin of frame b seen in frame a.

    Raises
    ------
    ValueError
        If `rotation` is not a proper rotation or an entry is not finite.
    """

    rotation: FloatArray
    translation_mm: FloatArray

    def __post_init__(self) -> None:
        rotation = frozen(self.rotation, (3, 3), "rotation")
        error = np.abs(rotation @ rotation.T - np.eye(3)).max()
        if not (error <= 1e-9 and np.linalg.det(rotation) > 0.0):
            raise ValueError(f"rotation must be a proper rotation, got {self.rotation!r}")
        object.__setattr__(self, "rotation", rotation)
        object.__setattr__(
            self, "translation_mm", frozen(self.translation_mm, (3,), "translation_mm")
        )

    @classmethod
    def from_rotation_vector(cls, rotation_vector: ArrayLike, translation_mm: ArrayLike) -> Self:
        """Make the motion that turns by a rotation vector (axis times angle, rad), then shifts."""
        matrix = Rotation.from_rotvec(np.asarray(rotation_vector, dtype=np.float64)).as_matrix()
        return cls(matrix, np.asarray(translation_mm, dtype=np.float64))

    @classmethod
    def identity(cls) -> Self:
        """Make the motion that changes nothing."""
        return cls(np.eye(3), np.zeros(3))

    @property
    def rotation_vector(self) -> FloatArray:
        """Shape (3,), axis times angle, rad."""
        return np.asarray(Rotation.from_matrix(self.rotation).as_rotvec(), dtype=np.float64)

    def apply(self, points_mm: FloatArray) -> FloatArray:
        """Map points, shape (N, 3), from frame b to frame a."""
        return points_mm @ self.rotation.T + self.translation_mm

    def inverse(self) -> "RigidTransform":
        """Return ``b_from_a``."""
        return RigidTransform(self.rotation.T, -self.rotation.T @ self.translation_mm)

    def __matmul__(self, other: "RigidTransform") -> "RigidTransform":
        return RigidTransform(
            self.rotation @ other.rotation,
            self.rotation @ other.translation_mm + self.translation_mm,
        )
