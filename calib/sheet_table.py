"""The sheet as a table: for pixels, the point on it and its uncertainty."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import FloatArray, read_only
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame

_ROWS_AT_ONCE = 32  # keeps the Jacobians of a full-size table within some 100 MB


@dataclass(frozen=True, slots=True, eq=False)
class SheetTable:
    """Where pixels see the sheet, for those who measure without this code.

    Attributes
    ----------
    frame
        The two coordinates (s, t) on the sheet.
    u_px, v_px
        Shapes (W,) and (H,), the columns and rows of pixels in the table.
    sheet_mm
        Shape (H, W, 2), (s, t); NaN where a pixel sees no sheet.
    in_cam_mm
        Shape (H, W, 3), the same points in the camera frame.
    sigma_mm
        Shape (H, W), standard deviation of the point along its worst direction, by the doubt of
        the calibration alone. It is common to all points: it does not average out.
    """

    frame: SheetFrame
    u_px: FloatArray
    v_px: FloatArray
    sheet_mm: FloatArray
    in_cam_mm: FloatArray
    sigma_mm: FloatArray

    def __post_init__(self) -> None:
        for name in ("u_px", "v_px", "sheet_mm", "in_cam_mm", "sigma_mm"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @classmethod
    def of(cls, sensor: LaserSensor, step_px: int = 8) -> Self:
        """Make the table of every `step_px`-th pixel, the picture's last ones included.

        Raises
        ------
        ValueError
            If `step_px` is less than 1.
        """
        if not step_px >= 1:
            raise ValueError(f"step_px must be at least 1, got {step_px}")
        frame = SheetFrame.of(sensor.plane)
        u, v = _places(sensor.camera.width, step_px), _places(sensor.camera.height, step_px)
        located, sigma = [], []
        for first in range(0, len(v), _ROWS_AT_ONCE):
            rows = v[first : first + _ROWS_AT_ONCE]
            pixels = np.stack(np.meshgrid(u, rows), axis=-1).reshape(-1, 2)
            located.append(sensor.locate(pixels).reshape(len(rows), len(u), 3))
            sigma.append(sensor.sigma_on_sheet(pixels).reshape(len(rows), len(u)))
        in_cam = np.concatenate(located)
        return cls(frame, u, v, frame.coordinates(in_cam), in_cam, np.concatenate(sigma))


def _places(count: int, step: int) -> FloatArray:
    places = np.arange(0, count, step, dtype=np.float64)
    return places if places[-1] == count - 1 else np.append(places, count - 1.0)
