"""Pixels carried back onto their boards, with what the places owe to pixel and pose."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.camera import CameraModel
from calib.solving.joint.discs import cross_matrices
from calib.solving.joint.parameters import POSE_SIZE, Estimate


@dataclass(frozen=True, slots=True, eq=False)
class BackProjection:
    """Where on its board each pixel lies.

    Attributes
    ----------
    rays, ray_by_pixel
        (x, y, 1) in the camera frame, shape (N, 3), and d(ray)/d(pixel), shape (N, 3, 2).
    place_mm
        Shape (N, 2), in the frame of the target.
    by_pixel, by_pose
        d(place)/d(pixel), mm/px, shape (N, 2, 2), and d(place)/d(pose), shape (N, 2, 6).
    """

    rays: FloatArray
    ray_by_pixel: FloatArray
    place_mm: FloatArray
    by_pixel: FloatArray
    by_pose: FloatArray

    @classmethod
    def of(
        cls, pixels_px: FloatArray, view: IntArray, camera: CameraModel, estimate: Estimate
    ) -> "BackProjection":
        r"""Carry pixels, shape (N, 2), of views, shape (N,), onto the boards.

        Notes
        -----
        The ray :math:`\rho` meets the board with the normal m and the origin t at

        .. math:: X = \rho \frac{m \cdot t}{m \cdot \rho}, \quad
                  \frac{\partial X}{\partial \rho} = \frac{m \cdot t}{m \cdot \rho}
                  \left(I - \frac{\rho m^T}{m \cdot \rho}\right).

        Where the board moves by Y under the ray, the place on it moves by
        :math:`R^T (\rho m^T / (m \cdot \rho) - I) Y`.
        """
        rays, ray_by_pixel, _ = camera.rays_with_jacobians(pixels_px)
        rotation, origin = estimate.rotation[view], estimate.translation_mm[view]
        normal, axes = rotation[:, :, 2], rotation[:, :, :2].transpose(0, 2, 1)
        along = np.einsum("ni,ni->n", normal, rays)
        depth = np.einsum("ni,ni->n", normal, origin) / along
        arm = rays * depth[:, None] - origin
        slide = rays[:, :, None] * normal[:, None, :] / along[:, None, None] - np.eye(3)
        by_pose = np.empty((len(rays), 2, POSE_SIZE))
        by_pose[:, :, 3:] = axes @ slide
        by_pose[:, :, :3] = -by_pose[:, :, 3:] @ cross_matrices(arm)
        return cls(
            rays=rays,
            ray_by_pixel=ray_by_pixel,
            place_mm=np.einsum("nij,nj->ni", axes, arm),
            by_pixel=-depth[:, None, None] * by_pose[:, :, 3:] @ ray_by_pixel,
            by_pose=by_pose,
        )
