"""Distances on the sheet against the same distances on the target: the paper's Table 4."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.arrays import FloatArray, read_only
from calib.errors import CalibError
from calib.judging.crossings import grid_crossings
from calib.sensor import LaserSensor
from calib.solving.start import has_stripe, start_pose, why_unusable
from calib.target import Target
from calib.views import View

_FEWEST_CROSSINGS = 2
# Off the target's own plane by more than this part of its distance, a stripe was not drawn by the
# sheet: a second one, thrown by a reflection, looks like it. A calibration is off by far less.
_FALSE_STRIPE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class PlacementDistances:
    """Distances from the first crossing to the others, at one placement of the target.

    Attributes
    ----------
    name
        Name of the view.
    lines
        What the stripe crossed: columns of the target or its rows.
    measured_mm
        Shape (K,), on the sheet, by the sensor.
    gauged_mm
        Shape (K,), on the target.
    reason
        Why there are none; empty where there are.
    """

    name: str
    lines: Literal["columns", "rows"]
    measured_mm: FloatArray
    gauged_mm: FloatArray
    reason: str = ""

    def __post_init__(self) -> None:
        for name in ("measured_mm", "gauged_mm"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def errors_mm(self) -> FloatArray:
        """Measured less gauged, shape (K,)."""
        return np.asarray(self.measured_mm - self.gauged_mm)


def judge_distances(
    views: Sequence[View], target: Target, sensor: LaserSensor
) -> tuple[PlacementDistances, ...]:
    """Measure the distances between the stripe's crossings with the grid of a target.

    Parameters
    ----------
    views
        Placements of the target; best ones that did not take part in the calibration.
    target
        The target, whose pitch is the gauge.
    sensor
        The sensor under test.

    Returns
    -------
    placements
        One for every view, in order; a view that cannot be measured says why.

    Notes
    -----
    Each crossing is measured where its ray meets the sheet, and gauged where the homography of
    the target has it. A shift that all crossings share cancels, as in the paper [1]_.

    References
    ----------
    .. [1] "High-accuracy calibration of line-structured light vision sensor by correction of
       image deviation", Optics Express 27(4), 2019, section 3.2.1.
    """
    return tuple(_placement(view, target, sensor) for view in views)


def _placement(view: View, target: Target, sensor: LaserSensor) -> PlacementDistances:
    reason = why_unusable(view, target) or ("" if has_stripe(view) else "no stripe across it")
    if reason:
        return _none(view, reason)
    try:
        crossings = grid_crossings(view, target, sensor.camera)
    except CalibError as error:
        return _none(view, str(error))
    measured = sensor.plane.intersect(crossings.rays_in_cam)
    if len(crossings) < _FEWEST_CROSSINGS:
        return _none(view, f"the stripe crosses {len(crossings)} lines of the grid; 2 are needed")
    if not np.isfinite(measured).all():
        return _none(view, "the sensor sees no sheet where the stripe is")
    off = _off_board(measured, view, target, sensor)
    if not off <= _FALSE_STRIPE:
        return _none(
            view, f"its stripe is {off:.1%} of its distance off the sheet: a reflection, not it"
        )
    return PlacementDistances(
        view.name, crossings.lines, _from_first(measured), _from_first(crossings.board_mm)
    )


def _off_board(
    points_in_cam_mm: FloatArray, view: View, target: Target, sensor: LaserSensor
) -> float:
    """Return how far points are before or behind the board, as a part of their distance."""
    cam_from_board = start_pose(view, target, sensor.camera)
    normal = cam_from_board.rotation[:, 2]
    on_board = normal @ cam_from_board.translation_mm / (points_in_cam_mm @ normal)
    return float(np.median(np.abs(on_board - 1.0)))


def _from_first(points_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(points_mm[1:] - points_mm[0], axis=1))


def _none(view: View, reason: str) -> PlacementDistances:
    return PlacementDistances(view.name, "columns", np.empty(0), np.empty(0), reason)
