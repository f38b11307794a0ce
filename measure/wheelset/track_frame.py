"""The one frame in which the rigs of both sides of a track stand."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib import POSE_PARAMETERS, FloatArray, Rig, RigidTransform, frozen

_SIZE = len(POSE_PARAMETERS)
# Rigs are laid along the track to a degree or two; what is farther off is another convention.
_LEAST_COSINE = 0.95


@dataclass(frozen=True, slots=True, eq=False)
class TrackFrame:
    """Where the left rig stands beside the right one.

    Rig y points to the field on both sides and z up, so the rigs are half a turn about the
    vertical apart: x, too, is reversed.

    Attributes
    ----------
    right_from_left
        Takes points in the left rig's frame to the right one's.
    covariance
        Shape (6, 6), in the order of `POSE_PARAMETERS`: a small turn (rad), applied from the left
        about the left rig's origin, and a shift (mm), both along the axes of the right rig.

    Raises
    ------
    ValueError
        If rig y does not point to the field on both sides, or the covariance is not one.
    """

    right_from_left: RigidTransform
    covariance: FloatArray

    def __post_init__(self) -> None:
        turn, shift = self.right_from_left.rotation, self.right_from_left.translation_mm
        if not (-turn[1, 1] >= _LEAST_COSINE and turn[2, 2] >= _LEAST_COSINE and shift[1] < 0.0):
            raise ValueError(
                "right_from_left must turn rig y about, keep z up and put the left rig at negative "
                f"y, as y points to the field on both sides; it takes y to {turn[:, 1].round(3)}, "
                f"z to {turn[:, 2].round(3)} and the left origin to {shift.round(1)}"
            )
        covariance = frozen(self.covariance, (_SIZE, _SIZE), "covariance")
        if not (np.allclose(covariance, covariance.T) and np.all(np.diag(covariance) >= 0.0)):
            raise ValueError("covariance must be symmetric, its diagonal not negative")
        object.__setattr__(self, "covariance", covariance)

    @classmethod
    def of_distance(cls, distance_mm: float, *, sigma_mm: float, sigma_turn_rad: float) -> Self:
        """Make the frame of rigs that stand opposite each other, from one distance.

        Parameters
        ----------
        distance_mm, sigma_mm
            From one rig's origin to the other's, along the axle, and its standard deviation.
        sigma_turn_rad
            How far the rigs are turned against each other, about each axis. A sheet that meets the
            flange back 0.4 m from the rig's origin makes 0.4 mm of 1 mrad.

        Notes
        -----
        How far the origins are apart along the rail and in height counts to second order only.
        """
        if not (sigma_mm > 0.0 and sigma_turn_rad > 0.0):
            raise ValueError(
                f"sigma_mm and sigma_turn_rad must be positive, got {sigma_mm}, {sigma_turn_rad}"
            )
        variances = np.array([sigma_turn_rad**2] * 3 + [0.0, sigma_mm**2, 0.0])
        half_turn = np.diag([-1.0, -1.0, 1.0])
        return cls(
            RigidTransform(half_turn, np.array([0.0, -distance_mm, 0.0])), np.diag(variances)
        )

    @classmethod
    def of_rig(cls, rig: Rig, anchor: str, right_from_anchor: RigidTransform) -> Self:
        r"""Make the frame from one calibration of the sensors of both sides.

        Parameters
        ----------
        rig
            Of both sides, in the frame of the left rig.
        anchor
            The sensor on the right that carries the right rig's frame.
        right_from_anchor
            Where its camera stands in that frame, by its survey.

        Notes
        -----
        With Q the turn of right_from_left and t the camera's place in the left frame, a turn w
        about the camera and a shift s, along the left rig's axes, turn the left rig in the right
        one by -Q w and shift it by -Q (t x w + s).
        """
        left_from_anchor = rig[anchor].rig_from_camera
        right_from_left = right_from_anchor @ left_from_anchor.inverse()
        turn = right_from_left.rotation
        change = np.zeros((_SIZE, _SIZE))
        change[:3, :3] = change[3:, 3:] = -turn
        change[3:, :3] = -turn @ np.cross(left_from_anchor.translation_mm, np.eye(3)).T
        pose = rig.columns(anchor)[-_SIZE:]
        return cls(right_from_left, change @ rig.covariance[np.ix_(pose, pose)] @ change.T)

    @property
    def axle_in_right(self) -> FloatArray:
        """Direction of an axle, towards the right: halfway between what the rigs take it for."""
        direction = np.array([0.0, 1.0, 0.0]) - self.right_from_left.rotation[:, 1]
        return np.asarray(direction / np.linalg.norm(direction))

    def moved_by(self, points_in_left_mm: FloatArray) -> FloatArray:
        """Return how points, shape (N, 3), move along the axle, per unit of each parameter, (N, 6).

        With a the point turned into the right frame and n the axle, a turn w moves it by
        n . (w x a) = w . (a x n).
        """
        axle = self.axle_in_right
        arms = points_in_left_mm @ self.right_from_left.rotation.T
        return np.hstack([np.cross(arms, axle), np.broadcast_to(axle, arms.shape)])
