r"""A camera from maps of a plane to pictures, in closed form [1]_, to start a solve from.

The two board axes are perpendicular and equally long, which gives two equations a picture:
:math:`h_1^T \omega h_2 = 0` and :math:`h_1^T \omega h_1 = h_2^T \omega h_2` with
:math:`\omega = K^{-T} K^{-1}`. The principal point is put at the middle of the picture: left free
it is ill determined, the more so as the maps do not know of the distortion, and it spoils the
focal length.

References
----------
.. [1] Z. Zhang, "A flexible new technique for camera calibration", IEEE Transactions on Pattern
   Analysis and Machine Intelligence 22(11), 2000.
"""

from collections.abc import Sequence

import numpy as np

from calib.arrays import FloatArray
from calib.errors import Degenerate
from calib.homography import pose_from_homography

# Focal lengths a lens may have, in picture widths: 5 mm and 1 m on a sensor of 11 mm.
_SHORTEST, _LONGEST = 0.3, 100.0
# Boards whose normals differ by less than this leave the focal length to the noise.
_LEAST_TILT_DEG = 3.0


def camera_from_homographies(
    homographies: Sequence[FloatArray], *, width: int, height: int
) -> FloatArray:
    """Return a camera without distortion that explains maps of a plane.

    Parameters
    ----------
    homographies
        Maps from the board, mm, to the picture, px, each of shape (3, 3).
    width, height
        Size of the picture, px.

    Returns
    -------
    camera
        Shape (9,), in the order of `calib.camera.PARAMETERS`.

    Raises
    ------
    Degenerate
        If the boards are parallel, so that the focal length cannot be told.
    """
    centre = np.array([(width - 1) / 2.0, (height - 1) / 2.0])
    to_units = np.array([[1.0, 0.0, -centre[0]], [0.0, 1.0, -centre[1]], [0.0, 0.0, width]]) / width
    maps = np.array([to_units @ homography for homography in homographies])
    maps /= np.linalg.norm(maps[:, :, :2], axis=(1, 2))[:, None, None]
    focal = _focal_lengths(maps)
    camera = np.array([focal[0] * width, focal[1] * width, *centre, 0.0, 0.0, 0.0, 0.0, 0.0])
    _refuse_parallel(maps, focal)
    return camera


def _focal_lengths(maps: FloatArray) -> FloatArray:
    """Return (fx, fy) in picture widths from maps to centred pictures in picture widths."""
    first, second = maps[:, :, 0], maps[:, :, 1]
    rows = np.concatenate([first * second, first**2 - second**2])
    # Unknowns 1/fx^2 and 1/fy^2; where noise makes one negative, one focal length serves both.
    for design in (rows[:, :2], rows[:, :2].sum(axis=1, keepdims=True)):
        solution = np.linalg.lstsq(design, -rows[:, 2], rcond=1e-9)[0]
        if ((solution > _LONGEST**-2.0) & (solution < _SHORTEST**-2.0)).all():
            return np.broadcast_to(1.0 / np.sqrt(solution), (2,))
    raise Degenerate(
        "the focal length cannot be told from these pictures: the target faces the camera in all "
        "of them; tilt it by 20 degrees or more about both axes, or give the camera"
    )


def _refuse_parallel(maps: FloatArray, focal: FloatArray) -> None:
    to_rays = np.diag([1.0 / focal[0], 1.0 / focal[1], 1.0])
    normals = np.array([pose_from_homography(to_rays @ each).rotation[:, 2] for each in maps])
    mean = normals.mean(axis=0) / np.linalg.norm(normals.mean(axis=0))
    tilt_deg = float(np.degrees(np.arccos(np.clip(normals @ mean, -1.0, 1.0))).max())
    if not tilt_deg >= _LEAST_TILT_DEG:
        raise Degenerate(
            f"the targets of all pictures are parallel within {tilt_deg:.1f} degrees, so the "
            "camera cannot be told; tilt the target by 20 degrees or more about both axes, or "
            "give the camera"
        )
