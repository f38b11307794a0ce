"""How a target stands before the camera, in words that a person can act on, and back."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray
from calib.rigid import RigidTransform
from calib.target import Target


@dataclass(frozen=True, slots=True)
class Standing:
    """Where a target is and which way it is turned.

    Attributes
    ----------
    middle_in_cam_mm
        The middle of its points, camera frame.
    tilt_deg
        Of its normal from the optical axis; 0 where it faces the picture, below 90.
    near_edge_deg
        Direction in the picture of the edge that is nearest to the camera: 0 is right, 90 is down.
        Of no meaning at a tilt of 0.

    Raises
    ------
    ValueError
        If the tilt is not between 0 and 90 degrees.
    """

    middle_in_cam_mm: tuple[float, float, float]
    tilt_deg: float
    near_edge_deg: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.tilt_deg < 90.0:
            raise ValueError(f"a tilt of {self.tilt_deg} degrees; allowed: 0 up to 90")

    @property
    def depth_mm(self) -> float:
        """Of the middle, along the optical axis."""
        return self.middle_in_cam_mm[2]


def standing_of(cam_from_board: RigidTransform, target: Target) -> Standing:
    """Return how a target stands that is seen from its front."""
    middle = cam_from_board.apply(_middle_mm(target))[0]
    away = cam_from_board.rotation[:, 2]
    # The normal points away from the camera, so it leans towards the edge that is near.
    tilt_deg = float(np.degrees(np.arccos(np.clip(away[2], -1.0, 1.0))))
    near_deg = float(np.degrees(np.arctan2(away[1], away[0])))
    x, y, z = middle.tolist()
    return Standing((x, y, z), min(tilt_deg, 89.9), near_deg)


def pose_of(standing: Standing, target: Target) -> RigidTransform:
    """Return cam_from_board of a target that stands so, its rows running down the picture."""
    tilt, near = np.radians([standing.tilt_deg, standing.near_edge_deg])
    axis = np.array([-np.sin(near), np.cos(near), 0.0])
    turned = RigidTransform.from_rotation_vector(tilt * axis, np.zeros(3))
    shift = np.array(standing.middle_in_cam_mm) - turned.apply(_middle_mm(target))[0]
    return RigidTransform(turned.rotation, shift)


def _middle_mm(target: Target) -> FloatArray:
    return np.asarray(target.points_mm.mean(axis=0, keepdims=True))
