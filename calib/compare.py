"""How far apart two sensors place the same pixels."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, read_only
from calib.errors import CameraMismatch
from calib.sensor import LaserSensor


def pixel_grid(width: int, height: int, step_px: int = 32) -> FloatArray:
    """Return pixels that cover a picture evenly, row by row.

    Parameters
    ----------
    width, height
        Size of the picture, px.
    step_px
        Distance of neighbours.

    Returns
    -------
    pixels_px
        Shape (N, 2).
    """
    u, v = np.meshgrid(
        np.arange(step_px / 2 - 0.5, width, step_px), np.arange(step_px / 2 - 0.5, height, step_px)
    )
    return np.column_stack([u.ravel(), v.ravel()])


def sheet_difference_mm(one: LaserSensor, other: LaserSensor, pixels_px: FloatArray) -> FloatArray:
    """Return how far two sensors place the points that pixels show from each other.

    Parameters
    ----------
    one, other
        The sensors; both in the frame of the same camera.
    pixels_px
        Shape (N, 2).

    Returns
    -------
    difference_mm
        Shape (N,), length of the difference of the two points; NaN where one of them sees no sheet.
    """
    return np.asarray(np.linalg.norm(one.locate(pixels_px) - other.locate(pixels_px), axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class SheetComparison:
    """Two sensors over a field.

    Attributes
    ----------
    pixels_px
        Shape (N, 2), the field.
    difference_mm
        Shape (N,), how far they place a pixel's point from each other; NaN where one of them
        sees no sheet.
    sigma_mm
        Shape (N,), what both covariances together make of that length: its expected root mean
        square where nothing but their scatter differs.
    """

    pixels_px: FloatArray
    difference_mm: FloatArray
    sigma_mm: FloatArray

    def __post_init__(self) -> None:
        for name in ("pixels_px", "difference_mm", "sigma_mm"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def rms_mm(self) -> float:
        """Root mean square difference over the field; NaN where the field is empty."""
        return _rms(self.difference_mm)

    @property
    def expected_mm(self) -> float:
        """Root mean square of `sigma_mm` over the field."""
        return _rms(self.sigma_mm)

    @property
    def worst(self) -> int:
        """Index of the pixel with the largest difference.

        Raises
        ------
        ValueError
            If there is none.
        """
        return int(np.nanargmax(self.difference_mm))

    @property
    def agree(self) -> bool:
        """Whether their uncertainties explain the difference.

        The mean square over a field is a weighted sum of at least one squared normal variable:
        it exceeds its expectation 1.96^2 = 3.84 times with a chance of 5 % at the most.
        """
        return bool(self.rms_mm <= 1.96 * self.expected_mm)


def compare_sensors(one: LaserSensor, other: LaserSensor, pixels_px: FloatArray) -> SheetComparison:
    """Tell how far two calibrations of one sensor differ, and whether they may.

    Parameters
    ----------
    one, other
        The sensors; both in the frame of the same camera, and taken as independent. Calibrations
        that share pictures, or a camera's own covariance, scatter less than this expects.
    pixels_px
        Shape (N, 2), the field.

    Raises
    ------
    CameraMismatch
        If the cameras are of different picture sizes.
    """
    ensure_same_pictures(one, other)
    covariance = one.location_covariance(pixels_px) + other.location_covariance(pixels_px)
    return SheetComparison(
        pixels_px,
        sheet_difference_mm(one, other, pixels_px),
        np.asarray(np.sqrt(np.trace(covariance, axis1=1, axis2=2))),
    )


def ensure_same_pictures(one: LaserSensor, other: LaserSensor) -> None:
    """Let only sensors be compared whose pictures have the same pixels.

    Raises
    ------
    CameraMismatch
        If the cameras are of different picture sizes.
    """
    if (one.camera.width, one.camera.height) != (other.camera.width, other.camera.height):
        raise CameraMismatch(
            f"calibrations of pictures of {one.camera.width} x {one.camera.height} px and of "
            f"{other.camera.width} x {other.camera.height} px have no pixel in common; compare two "
            "of one camera at one resolution"
        )


def _rms(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else float("nan")
