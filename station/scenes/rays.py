"""Where each pixel of a camera looks."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from calib import CameraModel
from station.scenes.patch import Window

_ROWS_AT_ONCE = 64  # keeps the double-precision intermediates within the processor's cache


def ray_map(camera: CameraModel, window: Window) -> NDArray[np.float32]:
    """Return x/z and y/z of the ray of every pixel of a window, shape (2, rows, columns).

    The whole picture is undistorted once per camera and kept. Single precision resolves 1e-4 px.
    """
    rows, columns = window.slices
    return _whole_map(tuple(camera.parameters), camera.width, camera.height)[:, rows, columns]


@lru_cache(maxsize=2)
def _whole_map(parameters: tuple[float, ...], width: int, height: int) -> NDArray[np.float32]:
    camera = CameraModel.from_parameters(np.array(parameters), width=width, height=height)
    rays = np.empty((2, height, width), dtype=np.float32)
    for top in range(0, height, _ROWS_AT_ONCE):
        v, u = np.mgrid[top : min(top + _ROWS_AT_ONCE, height), 0:width]
        block = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64))
        rays[:, top : top + len(u)] = block[:, :2].T.reshape(2, *u.shape)
    rays.setflags(write=False)
    return rays
