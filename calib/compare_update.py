"""How far a sensor has moved since its last calibration, apart from what neither knows of it."""

import numpy as np

from calib.arrays import FloatArray
from calib.camera import PARAMETERS
from calib.compare import SheetComparison, compare_sensors, ensure_same_pictures
from calib.plane import LightPlane
from calib.sensor import LaserSensor

_OF_CAMERA = slice(0, len(PARAMETERS))


def compare_sheets(
    before: LaserSensor, after: LaserSensor, pixels_px: FloatArray
) -> SheetComparison:
    r"""Tell how far the sheet has moved between two calibrations, seen through the earlier camera.

    What a few poses leave open of the camera makes two calibrations differ by a multiple of what
    they leave open of the sheet before a known camera. Seen through one camera, the sheet tells
    of far smaller motions; a change of the camera itself it hides, see `compare_update`.

    Parameters
    ----------
    before, after
        The calibrations, from different pictures.
    pixels_px
        Shape (N, 2), the field.

    Returns
    -------
    SheetComparison
        With the sheet that `after` would have found, had it taken the camera of `before`.

    Raises
    ------
    CameraMismatch
        If the cameras are of different picture sizes.

    Notes
    -----
    The covariance of a calibration, in blocks of camera c and plane p, holds how its plane follows
    its camera, :math:`B = C_{pc} C_{cc}^{-1}`, and what it leaves open of the plane where the
    camera is known, :math:`C_{p|c} = C_{pp} - B C_{cp}`. Moved to the camera of `before`, the plane
    of `after` is :math:`p' + B' (c - c')`, and it differs from p with the covariance

    .. math:: C_{p|c} + C'_{p|c} + (B' - B)\, C_{cc}\, (B' - B)^T

    whose last term is what the camera's error does to planes from different poses.
    """
    ensure_same_pictures(before, after)
    planes = slice(len(PARAMETERS), None)
    follows = [_plane_by_camera(sensor) for sensor in (before, after)]
    to_before = before.camera.parameters - after.camera.parameters
    moved = after.plane.coefficients + follows[1] @ to_before
    seen_so = LaserSensor(before.camera, LightPlane.from_coefficients(moved), after.covariance)
    apart = compare_sensors(before, seen_so, pixels_px).difference_mm
    unlike = follows[1] - follows[0]
    covariance = unlike @ before.covariance[_OF_CAMERA, _OF_CAMERA] @ unlike.T + sum(
        _of_plane_alone(sensor)[planes, planes] for sensor in (before, after)
    )
    _, by_before = before.location_jacobians(pixels_px)
    by_plane = by_before[:, :, planes]
    variance = np.trace(by_plane @ covariance @ by_plane.transpose(0, 2, 1), axis1=1, axis2=2)
    return SheetComparison(pixels_px, apart, np.asarray(np.sqrt(variance)))


def compare_update(
    before: LaserSensor, after: LaserSensor, pixels_px: FloatArray
) -> SheetComparison:
    r"""Tell how far a sensor has moved since the calibration whose camera was the next one's prior.

    What the pictures of a few poses leave open of the camera moves both sheets alike, and is no
    part of their difference: taken as independent, they would seem to agree however far the sheet
    has moved.

    Parameters
    ----------
    before
        The earlier calibration.
    after
        One solved from other pictures, with the camera of `before` and its covariance as prior.
    pixels_px
        Shape (N, 2), the field.

    Returns
    -------
    SheetComparison
        `sigma_mm` is what the pictures of both leave to chance.

    Raises
    ------
    CameraMismatch
        If the cameras are of different picture sizes.

    Notes
    -----
    With the covariances C of `before` and N of `after`, in blocks of camera c and plane p, the
    normal equations of `after` hold the prior :math:`C_{cc}^{-1} c`, hence

    .. math:: \mathrm{cov}(\theta_{after}, \theta_{before}) = N_{\cdot c}
              \, [\,1 \quad C_{cc}^{-1} C_{cp}\,]

    and the difference of what both make of a pixel has the covariance
    :math:`J C J^T + J' N J'^T - J' \mathrm{cov} J^T - (\cdot)^T`. Where one of the covariances was
    scaled by its residuals and the other was not, that could come out too small: it is held at
    least at what both planes leave open for a camera that is known.
    """
    independent = compare_sensors(before, after, pixels_px)
    _, by_before = before.location_jacobians(pixels_px)
    _, by_after = after.location_jacobians(pixels_px)
    shared = by_after @ _covariance_of_both(before, after) @ by_before.transpose(0, 2, 1)
    variance = independent.sigma_mm**2 - 2.0 * np.trace(shared, axis1=1, axis2=2)
    least = sum(
        np.trace(jacobian @ _of_plane_alone(sensor) @ jacobian.transpose(0, 2, 1), axis1=1, axis2=2)
        for sensor, jacobian in ((before, by_before), (after, by_after))
    )
    return SheetComparison(
        pixels_px, independent.difference_mm, np.asarray(np.sqrt(np.maximum(variance, least)))
    )


def _covariance_of_both(before: LaserSensor, after: LaserSensor) -> FloatArray:
    """Return cov(after, before), shape (13, 13)."""
    with_plane = _information_of_camera(before) @ before.covariance[_OF_CAMERA]
    return np.asarray(after.covariance[:, _OF_CAMERA] @ with_plane)


def _plane_by_camera(sensor: LaserSensor) -> FloatArray:
    """Return how a sensor's plane follows its camera, shape (4, 9)."""
    covariance = sensor.covariance[len(PARAMETERS) :, _OF_CAMERA]
    return np.asarray(covariance @ _information_of_camera(sensor))


def _of_plane_alone(sensor: LaserSensor) -> FloatArray:
    """Return the covariance of a sensor whose camera is known, shape (13, 13)."""
    covariance = sensor.covariance
    information = _information_of_camera(sensor)
    known = covariance - covariance[:, _OF_CAMERA] @ information @ covariance[_OF_CAMERA]
    known[_OF_CAMERA] = 0.0
    known[:, _OF_CAMERA] = 0.0
    return np.asarray(known)


def _information_of_camera(sensor: LaserSensor) -> FloatArray:
    """Return the inverse of the camera's covariance, zero for what was not estimated, (9, 9)."""
    covariance = sensor.covariance[_OF_CAMERA, _OF_CAMERA]
    sigma = np.sqrt(np.diag(covariance))
    scale = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=sigma > 0.0)
    # By correlations: pixels and distortion differ by orders of magnitude, which the
    # pseudo-inverse would take for a lack of rank.
    correlation = covariance * np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(correlation, hermitian=True) * np.outer(scale, scale))
