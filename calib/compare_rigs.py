"""How far apart two calibrations of one rig place what a sensor sees, beside another sensor."""

import numpy as np

from calib.arrays import FloatArray
from calib.compare import SheetComparison
from calib.errors import CameraMismatch
from calib.rig import POSE_PARAMETERS, Rig


def compare_placings(
    one: Rig, other: Rig, *, sensor: str, anchor: str, pixels_px: FloatArray
) -> SheetComparison:
    r"""Tell how far two rigs place the points of a sensor from each other, seen from the anchor.

    Parameters
    ----------
    one, other
        Two calibrations of one rig, each in any frame, taken as independent.
    sensor
        Whose points.
    anchor
        The sensor in whose camera frame they are compared.
    pixels_px
        Shape (N, 2), the field in the sensor's picture.

    Returns
    -------
    SheetComparison
        A difference is NaN where one of them sees no sheet.

    Raises
    ------
    CameraMismatch
        If the cameras of the sensor are of different picture sizes.

    Notes
    -----
    A point is :math:`R_a^T (R_s p + t_s - t_a)`. With :math:`q = R_s p` and
    :math:`r = R_s p + t_s - t_a` a small turn and shift of the sensor's pose move it by
    :math:`R_a^T (\omega_s \times q + \tau_s)`, those of the anchor's by
    :math:`-R_a^T (\omega_a \times r + \tau_a)`.
    """
    cameras = [rig[sensor].sensor.camera for rig in (one, other)]
    sizes = [f"{camera.width} x {camera.height} px" for camera in cameras]
    if sizes[0] != sizes[1]:
        raise CameraMismatch(
            f"sensor {sensor} has pictures of {sizes[0]} in one rig, of {sizes[1]} in the other; "
            "compare two of one camera"
        )
    (first, first_covariance), (second, second_covariance) = (
        seen_from(rig, sensor, anchor, pixels_px) for rig in (one, other)
    )
    covariance = first_covariance + second_covariance
    return SheetComparison(
        pixels_px,
        np.asarray(np.linalg.norm(first - second, axis=1)),
        np.asarray(np.sqrt(np.trace(covariance, axis1=1, axis2=2))),
    )


def seen_from(
    rig: Rig, sensor: str, anchor: str, pixels_px: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the points in the anchor's camera frame, shape (N, 3), and their covariances."""
    placed, base = rig[sensor], rig[anchor].rig_from_camera
    in_cam, _, by_sensor = placed.sensor.locate_with_jacobians(pixels_px)
    turned = in_cam @ placed.rig_from_camera.rotation.T
    from_base = turned + placed.rig_from_camera.translation_mm - base.translation_mm
    jacobian = np.concatenate(
        [
            placed.rig_from_camera.rotation @ by_sensor,
            _by_pose(turned),
            -_by_pose(from_base),
        ],
        axis=2,
    )
    jacobian = base.rotation.T @ jacobian
    columns = np.concatenate([rig.columns(sensor), rig.columns(anchor)[-len(POSE_PARAMETERS) :]])
    covariance = rig.covariance[np.ix_(columns, columns)]
    return from_base @ base.rotation, jacobian @ covariance @ jacobian.transpose(0, 2, 1)


def _by_pose(points_mm: FloatArray) -> FloatArray:
    """Return the derivative by a turn and a shift, shape (N, 3, 6)."""
    turn = np.cross(np.eye(3)[None, :, :], points_mm[:, None, :]).transpose(0, 2, 1)
    shift = np.broadcast_to(np.eye(3), (len(points_mm), 3, 3))
    return np.concatenate([turn, shift], axis=2)
