"""The unknowns of a rig: what they are, how a step moves them, which columns they have.

This file owns the order of the parameter vector: each sensor's own, in standard deviations of what
was known of it; the pose of each camera but the anchor's; of each board but the first; of the
target at each showing. A pose steps by a small rotation, from the left, and a shift, both along
the axes of the frame it maps to, as in `calib.rig`. The dots' places on the boards stand beside:
they are eliminated first.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.arrays import FloatArray
from calib.camera import PARAMETERS
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.solving.joint.parameters import (
    POSE_SIZE,
    Estimate,
    Layout,
    orthonormal,
    tangent_basis,
)

FULL_LAYOUT = Layout(tuple(range(len(PARAMETERS))), plane=True)
"""Of one sensor: the whole camera and the sheet."""

# Of a correlation matrix, whose eigenvalues are 1 on average: what is less is rounding.
_LEAST_EIGENVALUE = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class SensorPrior:
    r"""What is known of a sensor beforehand, and its parameters in those standard deviations.

    With the covariance :math:`C = L L^T`, the sensor is :math:`\theta_0 + L z`, and the prior of z
    is the unit normal one. Parameters that were held have no column; strong correlations, and
    variances ten orders apart, do no harm.

    Attributes
    ----------
    sensor
        As calibrated.
    root
        L, shape (12, R), in the order of `FULL_LAYOUT`.
    """

    sensor: LaserSensor
    root: FloatArray

    @classmethod
    def of(cls, sensor: LaserSensor) -> "SensorPrior":
        """Make the prior of a calibrated sensor."""
        to_sensor = FULL_LAYOUT.sensor_from_global(_estimate(sensor))
        covariance = to_sensor.T @ sensor.covariance @ to_sensor
        scale = np.sqrt(np.diag(covariance))
        safe = np.where(scale > 0.0, scale, 1.0)
        values, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
        known = values > _LEAST_EIGENVALUE
        return cls(sensor, scale[:, None] * axes[:, known] * np.sqrt(values[known]))

    @property
    def size(self) -> int:
        """R: how many parameters of the sensor are open."""
        return int(self.root.shape[1])

    def at(self, own: FloatArray) -> Estimate:
        """Return the sensor of a state, shape (R,), without poses."""
        start, step = _estimate(self.sensor), self.root @ own
        return FULL_LAYOUT.moved(start, step, np.zeros((0, POSE_SIZE)))

    def step_by_own(self, own: FloatArray) -> FloatArray:
        """Return d(a step from there, in the order of `FULL_LAYOUT`)/d(own), shape (12, R)."""
        plane = self.sensor.plane.normal_in_cam
        basis, step = tangent_basis(plane), (self.root @ own)[FULL_LAYOUT.plane_columns]
        raised = plane + basis @ step[:2]
        length = float(np.linalg.norm(raised))
        chain = np.eye(len(self.root))
        # Both normals' tangents are orthonormal; the length's own slope lies along the normal.
        angles = range(FULL_LAYOUT.plane_columns.start, FULL_LAYOUT.plane_columns.start + 2)
        chain[np.ix_(angles, angles)] = tangent_basis(raised / length).T @ basis / length
        return np.asarray(chain @ self.root)


def _estimate(sensor: LaserSensor) -> Estimate:
    return Estimate.start(sensor.camera, sensor.plane, [])


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Several maps of one kind: rotations, shape (N, 3, 3), and places, shape (N, 3), mm."""

    rotation: FloatArray
    place_mm: FloatArray

    @classmethod
    def of(cls, maps: Sequence[RigidTransform]) -> "Poses":
        """Stack maps."""
        return cls(
            np.array([each.rotation for each in maps]).reshape(-1, 3, 3),
            np.array([each.translation_mm for each in maps]).reshape(-1, 3),
        )

    def __getitem__(self, index: int) -> RigidTransform:
        return RigidTransform(self.rotation[index], self.place_mm[index])

    def moved(self, steps: FloatArray) -> "Poses":
        """Return the maps after steps, shape (N, 6)."""
        turns = Rotation.from_rotvec(steps[:, :3]).as_matrix().reshape(-1, 3, 3)
        return Poses(orthonormal(turns @ self.rotation), self.place_mm + steps[:, 3:])


@dataclass(frozen=True, slots=True, eq=False)
class RigState:
    """A state of a solve.

    Attributes
    ----------
    own
        Of each of K sensors, its own parameters, in prior standard deviations.
    cameras, boards, targets
        rig_from_camera of each sensor; target_from_board of each of B boards; rig_from_target at
        each of S showings.
    dot_shift_mm
        Shape (D, 3), how far the dots of all boards, board after board, are off their places.
    """

    own: tuple[FloatArray, ...]
    cameras: Poses
    boards: Poses
    targets: Poses
    dot_shift_mm: FloatArray


@dataclass(frozen=True, slots=True)
class RigLayout:
    """Which columns the unknowns have.

    Attributes
    ----------
    own_sizes
        How many parameters of each sensor are open.
    anchor
        Index of the sensor whose camera carries the frame. The first board carries the target's.
    boards, showings
        How many there are.
    """

    own_sizes: tuple[int, ...]
    anchor: int
    boards: int
    showings: int

    @property
    def _first_camera(self) -> int:
        return sum(self.own_sizes)

    @property
    def _first_board(self) -> int:
        return self._first_camera + POSE_SIZE * (len(self.own_sizes) - 1)

    @property
    def _first_target(self) -> int:
        return self._first_board + POSE_SIZE * (self.boards - 1)

    @property
    def size(self) -> int:
        """P: how many unknowns there are, the dots apart."""
        return self._first_target + POSE_SIZE * self.showings

    def own(self, sensor: int) -> slice:
        """Return the columns of a sensor's own parameters."""
        first = sum(self.own_sizes[:sensor])
        return slice(first, first + self.own_sizes[sensor])

    def camera(self, sensor: int) -> slice:
        """Return the columns of a camera's pose; empty for the anchor's."""
        if sensor == self.anchor:
            return slice(0, 0)
        return _block(self._first_camera, sensor - (sensor > self.anchor))

    def board(self, board: int) -> slice:
        """Return the columns of a board's pose; empty for the first."""
        return _block(self._first_board, board - 1) if board else slice(0, 0)

    def target(self, showing: int) -> slice:
        """Return the columns of the target's pose at a showing."""
        return _block(self._first_target, showing)

    def moved(self, state: RigState, step: FloatArray, dot_steps: FloatArray) -> RigState:
        """Return the state a step away; shapes (P,) and (D, 3)."""
        cameras = np.zeros((len(self.own_sizes), POSE_SIZE))
        others = np.arange(len(self.own_sizes)) != self.anchor
        cameras[others] = step[self._first_camera : self._first_board].reshape(-1, POSE_SIZE)
        boards = np.zeros((self.boards, POSE_SIZE))
        boards[1:] = step[self._first_board : self._first_target].reshape(-1, POSE_SIZE)
        return replace(
            state,
            own=tuple(own + step[self.own(index)] for index, own in enumerate(state.own)),
            cameras=state.cameras.moved(cameras),
            boards=state.boards.moved(boards),
            targets=state.targets.moved(step[self._first_target :].reshape(-1, POSE_SIZE)),
            dot_shift_mm=state.dot_shift_mm + dot_steps,
        )


def _block(first: int, index: int) -> slice:
    return slice(first + POSE_SIZE * index, first + POSE_SIZE * (index + 1))
