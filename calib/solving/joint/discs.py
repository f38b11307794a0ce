r"""Where the centroid of a disc's picture lies: not where its centre is seen.

A disc of radius :math:`\rho` on a plane is seen as an ellipse whose centre is the picture of the
pole of the vanishing line. With the depth :math:`z(q)` of the board point q, whose gradient on
the board is :math:`(R_{31}, R_{32})`, that pole is exactly

.. math:: q - \frac{\rho^2}{z(q)} (R_{31}, R_{32}),

so the correction is a shift of the point on the board, and its derivatives are plain. What the
lens then does to the ellipse is second order; it is taken by a four-point rule of degree 3 for
the mean over an ellipse, each point weighted by the area its surroundings take in the picture.
"""

import numpy as np

from calib.arrays import FloatArray
from calib.lens import picture_of, picture_slope


def ellipse_centres(
    points_in_cam_mm: FloatArray, normal: FloatArray, radius_mm: float
) -> FloatArray:
    """Return the board points whose pictures are the centres of the discs' ellipses.

    Parameters
    ----------
    points_in_cam_mm
        Shape (N, 3), centres of the discs, camera frame.
    normal
        Shape (N, 3), unit normal of each disc's board, camera frame.
    radius_mm
        Radius of the discs.

    Returns
    -------
    centres_in_cam_mm
        Shape (N, 3).
    """
    return points_in_cam_mm - _shift_per_depth(points_in_cam_mm, normal, radius_mm)


def ellipse_centre_jacobians(
    points_in_cam_mm: FloatArray, normal: FloatArray, radius_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Return what `ellipse_centres` owes to the point and to a small turn of the normal.

    Returns
    -------
    by_point
        Shape (N, 3, 3).
    by_turn
        d(centre)/d(rotation vector, from the left) by the normal alone, mm/rad, shape (N, 3, 3).
    """
    depth = points_in_cam_mm[:, 2]
    shift = _shift_per_depth(points_in_cam_mm, normal, radius_mm)
    by_point = np.tile(np.eye(3), (len(depth), 1, 1))
    by_point[:, :, 2] += shift / depth[:, None]
    # shift = factor (e3 - n_z n), and a turn w moves n by w x n.
    factor = (radius_mm**2 / depth)[:, None, None]
    normal_by_turn = -cross_matrices(normal)
    turned = (
        normal[:, :, None] * normal_by_turn[:, 2:, :] + normal[:, 2, None, None] * normal_by_turn
    )
    return by_point, factor * turned


def lens_shifts(
    centres_in_cam_mm: FloatArray, axes: FloatArray, radius_mm: float, camera: FloatArray
) -> FloatArray:
    """Return how far the lens moves the centroids of ellipses off their centres' pictures.

    Parameters
    ----------
    centres_in_cam_mm
        Shape (N, 3), from `ellipse_centres`.
    axes
        Shape (N, 3, 2), the two board axes in the camera frame.
    radius_mm
        Radius of the discs.
    camera
        Shape (9,).

    Returns
    -------
    shift_px
        Shape (N, 2).
    """
    depth = centres_in_cam_mm[:, 2]
    middle = centres_in_cam_mm[:, :2] / depth[:, None]
    half_axes = (axes[:, :2] - middle[:, :, None] * axes[:, 2:]) / depth[:, None, None]
    reach = half_axes * (radius_mm / np.sqrt(2.0))
    total, moment = np.zeros(len(depth)), np.zeros((len(depth), 2))
    for offset in (reach[:, :, 0], -reach[:, :, 0], reach[:, :, 1], -reach[:, :, 1]):
        slope = picture_slope(middle + offset, camera)
        area = slope[:, 0, 0] * slope[:, 1, 1] - slope[:, 0, 1] * slope[:, 1, 0]
        total += area
        moment += area[:, None] * picture_of(middle + offset, camera)
    return moment / total[:, None] - picture_of(middle, camera)


def cross_matrices(vectors: FloatArray) -> FloatArray:
    """Return the matrices, shape (N, 3, 3), that multiply from the left like ``vector x``."""
    matrices = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrices[:, 0, 1], matrices[:, 0, 2], matrices[:, 1, 2] = -z, y, -x
    matrices[:, 1, 0], matrices[:, 2, 0], matrices[:, 2, 1] = z, -y, x
    return matrices


def _shift_per_depth(points: FloatArray, normal: FloatArray, radius_mm: float) -> FloatArray:
    across = -normal[:, 2:] * normal
    across[:, 2] += 1.0
    return across * (radius_mm**2 / points[:, 2:])
