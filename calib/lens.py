"""OpenCV's lens model on normalised coordinates (x/z, y/z), with its derivatives and its inverse.

Everything here takes the camera as a plain vector of nine numbers in the order of
``calib.camera.PARAMETERS``, so that a solver can try values no `CameraModel` would accept.
"""

import numpy as np

from calib.arrays import FloatArray

_NEWTON_STEPS = 25
# Rays of a 3,000 px focal length: 1e-13 is a ten-millionth of a thousandth of a pixel.
_NEWTON_DONE = 1e-13


def picture_of(normalised: FloatArray, camera: FloatArray) -> FloatArray:
    """Return the pixels, shape (N, 2), of normalised coordinates, shape (N, 2)."""
    fx, fy, cx, cy = camera[:4]
    x_seen, y_seen = _distort(normalised, camera)
    return np.column_stack([fx * x_seen + cx, fy * y_seen + cy])


def picture_slope(normalised: FloatArray, camera: FloatArray) -> FloatArray:
    """Return d(pixel)/d(normalised), shape (N, 2, 2)."""
    fx, fy = camera[:2]
    xx, xy, yy = _distortion_slope(normalised, camera)
    slope = np.empty((len(normalised), 2, 2))
    slope[:, 0, 0], slope[:, 0, 1] = fx * xx, fx * xy
    slope[:, 1, 0], slope[:, 1, 1] = fy * xy, fy * yy
    return slope


def picture_by_camera(normalised: FloatArray, camera: FloatArray) -> FloatArray:
    """Return d(pixel)/d(camera parameters), shape (N, 2, 9)."""
    fx, fy = camera[:2]
    x, y = normalised.T
    r2 = x * x + y * y
    jacobian = np.zeros((len(normalised), 2, 9))
    jacobian[:, 0, 0], jacobian[:, 1, 1] = _distort(normalised, camera)
    jacobian[:, 0, 2] = jacobian[:, 1, 3] = 1.0
    for column, radial in ((4, r2), (5, r2 * r2), (8, r2 * r2 * r2)):
        jacobian[:, 0, column] = fx * x * radial
        jacobian[:, 1, column] = fy * y * radial
    jacobian[:, 0, 6], jacobian[:, 1, 6] = fx * 2.0 * x * y, fy * (r2 + 2.0 * y * y)
    jacobian[:, 0, 7], jacobian[:, 1, 7] = fx * (r2 + 2.0 * x * x), fy * 2.0 * x * y
    return jacobian


def normalised_of(
    pixels_px: FloatArray, camera: FloatArray, start: FloatArray | None = None
) -> FloatArray:
    """Return the normalised coordinates that pixels show, by Newton's method.

    Parameters
    ----------
    pixels_px
        Shape (N, 2).
    camera
        Shape (9,).
    start
        Shape (N, 2), a guess; without it the distorted coordinates themselves.

    Returns
    -------
    normalised
        Shape (N, 2); a row is NaN where the lens model has no inverse, that is beyond the radius
        where it folds the picture over.
    """
    seen = (pixels_px - camera[2:4]) / camera[:2]
    guess = seen.copy() if start is None else start.copy()
    if not camera[4:].any():
        return seen
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            x_seen, y_seen = _distort(guess, camera)
            xx, xy, yy = _distortion_slope(guess, camera)
            miss_x, miss_y = x_seen - seen[:, 0], y_seen - seen[:, 1]
            determinant = xx * yy - xy * xy
            step_x = (yy * miss_x - xy * miss_y) / determinant
            step_y = (xx * miss_y - xy * miss_x) / determinant
            guess -= np.column_stack([step_x, step_y])
            size = np.maximum(np.abs(step_x), np.abs(step_y))
            if not (size > _NEWTON_DONE).any():
                break
        unfolded = (determinant > 0.0) & (xx > 0.0) & (size <= 1e-9)
    return np.where(unfolded[:, None], guess, np.nan)


def _distort(normalised: FloatArray, camera: FloatArray) -> tuple[FloatArray, FloatArray]:
    k1, k2, p1, p2, k3 = camera[4:]
    x, y = normalised.T
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xy = 2.0 * x * y
    return (
        x * radial + p1 * xy + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + p2 * xy,
    )


def _distortion_slope(
    normalised: FloatArray, camera: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    # The slope of this lens model is symmetric: dx'/dy = dy'/dx.
    k1, k2, p1, p2, k3 = camera[4:]
    x, y = normalised.T
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    bend = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    return (
        radial + x * x * bend + 2.0 * p1 * y + 6.0 * p2 * x,
        x * y * bend + 2.0 * p1 * x + 2.0 * p2 * y,
        radial + y * y * bend + 6.0 * p1 * y + 2.0 * p2 * x,
    )
