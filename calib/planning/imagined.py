"""A picture of a target as a sensor would take it, before anybody takes it."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.target import Target
from calib.views import Cause, StripePoints, TargetPoints, View

_STRIPE_POINTS = 60
"""Points of a stripe: as dense as needed for it to be a curve; their sigma carries the rest."""
_BORDER = 0.02
"""Of the picture's size: a board nearer to the border is easily cut off by it."""
_LEAST_CROSSING = 0.25
"""Sine of the angle between board and sheet: below, the stripe is a smear over the board."""


@dataclass(frozen=True, slots=True)
class Scatter:
    """How the points of pictures scatter.

    Attributes
    ----------
    dot_px
        Standard deviation of a dot along each of u and v.
    stripe_px
        Standard deviation across the stripe that all its points together are worth, as one of
        `_STRIPE_POINTS` points.

    Raises
    ------
    ValueError
        If one is not positive.
    """

    dot_px: float
    stripe_px: float

    def __post_init__(self) -> None:
        if not min(self.dot_px, self.stripe_px) > 0.0:
            raise ValueError(f"a scatter of {self.dot_px} and {self.stripe_px} px; allowed: above")

    @classmethod
    def of(cls, views: "list[View] | tuple[View, ...]") -> "Scatter":
        """Return that of views; of the first picture, what pictures usually have."""
        dots = [float(np.median(view.points.sigma_px)) for view in views if len(view.points)]
        stripes = [
            float(np.sqrt(_STRIPE_POINTS / np.sum(view.stripe.sigma_px**-2.0)))
            for view in views
            if view.stripe is not None and len(view.stripe)
        ]
        return cls(
            float(np.median(dots)) if dots else _USUAL.dot_px,
            float(np.median(stripes)) if stripes else _USUAL.stripe_px,
        )


_USUAL = Scatter(0.05, 0.1)


def imagined_view(
    sensor: LaserSensor, target: Target, cam_from_board: RigidTransform, scatter: Scatter
) -> View | None:
    """Return what a picture would show of a target, without noise.

    Parameters
    ----------
    sensor
        The camera and the sheet.
    cam_from_board
        Where the target stands.
    scatter
        How points scatter.

    Returns
    -------
    View
        All dots, and the stripe where the sheet crosses the board; None where a dot is not well
        inside the picture, or the sheet does not cross the board clearly.
    """
    points = cam_from_board.apply(target.points_mm)
    if not points[:, 2].min() > 0.0:
        return None
    dots_px = sensor.camera.project(points)
    if not _inside(dots_px, sensor).all():
        return None
    stripe_px = _stripe_px(sensor, target, cam_from_board)
    if stripe_px is None:
        return None
    row, col = np.divmod(np.arange(len(dots_px)), target.cols)
    dots = TargetPoints(
        row, col, dots_px, np.full((len(row), 2), scatter.dot_px), (Cause.NONE,) * len(row)
    )
    return View("imagined", dots, _stripe(stripe_px, scatter.stripe_px))


def _inside(pixels_px: FloatArray, sensor: LaserSensor) -> BoolArray:
    size = np.array([sensor.camera.width, sensor.camera.height])
    margin = _BORDER * size
    return np.asarray(((pixels_px > margin) & (pixels_px < size - 1.0 - margin)).all(axis=1))


def _stripe_px(
    sensor: LaserSensor, target: Target, cam_from_board: RigidTransform
) -> FloatArray | None:
    """Return places along the stripe between the borders of the board; None without one."""
    # The sheet in the frame of the board: n . (R q + t) + d = 0 at q = (x, y, 0).
    normal = sensor.plane.normal_in_cam @ cam_from_board.rotation
    offset = sensor.plane.distance_mm(cam_from_board.translation_mm[None, :])[0]
    across = float(np.hypot(normal[0], normal[1]))
    if not across > _LEAST_CROSSING:
        return None
    foot = -offset * normal[:2] / across**2
    along = np.array([-normal[1], normal[0]]) / across
    reach = _reach_mm(foot, along, target)
    if reach is None:
        return None
    places = foot + np.linspace(*reach, _STRIPE_POINTS)[:, None] * along
    on_board = np.column_stack([places, np.zeros(len(places))])
    return sensor.camera.project(cam_from_board.apply(on_board))


def _reach_mm(foot: FloatArray, along: FloatArray, target: Target) -> tuple[float, float] | None:
    """Return from where to where a line lies on the board; None where that is less than a half."""
    size = np.array([target.cols - 1, target.rows - 1]) * target.pitch_mm
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([-foot, size - foot]) / along, axis=0)
    first, last = float(np.nanmax(ends[0])), float(np.nanmin(ends[1]))
    return (first, last) if last - first > 0.5 * size.min() else None


def _stripe(centre_px: FloatArray, sigma_px: float) -> StripePoints:
    slope = np.gradient(centre_px, axis=0)
    normal = np.column_stack([-slope[:, 1], slope[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    count = len(centre_px)
    return StripePoints(
        centre_px=centre_px,
        normal=normal,
        sigma_px=np.full(count, sigma_px),
        width_px=np.full(count, 2.0),
        peak=np.full(count, 100.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
