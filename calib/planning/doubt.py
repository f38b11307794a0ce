r"""What pictures leave open of the sheet over a field, and what one more would leave.

Views share nothing but camera and plane. Of the normal equations of one view, with the blocks of
its pose U, of camera and plane G, and X between them, what it tells of camera and plane is

.. math:: S = G - X^T U^{-1} X,

and what several tell adds up.  So what another view would bring costs one small matrix more.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from calib.arrays import FloatArray, frozen
from calib.camera import PARAMETERS
from calib.errors import NotConverged
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.observations import Observations
from calib.target import Target
from calib.views import View

_FREE = tuple(PARAMETERS.index(name) for name in ("fx", "fy", "cx", "cy", "k1", "k2"))
"""What every solve estimates; further terms join where pictures ask for them."""
_LAYOUT = Layout(_FREE, plane=True)
_FOCAL_PART, _CENTRE_PART, _DISTORTION = 0.3, 0.2, 1.0
_ANGLE_RAD, _OFFSET_PART = 0.5, 0.5


def information_of(
    view: View, target: Target, sensor: LaserSensor, cam_from_board: RigidTransform
) -> FloatArray:
    """Return what a view tells of camera and sheet, its own pose unknown, shape (9, 9).

    Parameters
    ----------
    view
        Dots and stripe; their sigma say how they scatter.
    target, sensor, cam_from_board
        Where the equations are linear; the covariance of `sensor` is not looked at.

    Raises
    ------
    NotConverged
        If the view does not determine its own pose.
    """
    seen = Observations.of([view], target)
    state = Estimate.start(sensor.camera, sensor.plane, [cam_from_board])
    equations = NormalEquations.of(
        linearise_dots(seen, state, _LAYOUT), np.ones(len(seen.dots)), seen.dots.view, 1
    ) + NormalEquations.of(
        linearise_stripe(seen.stripe, state, _LAYOUT),
        np.ones(len(seen.stripe)),
        seen.stripe.view,
        1,
    )
    try:
        of_pose = np.linalg.solve(equations.views[0], equations.border[0])
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"{view.name} does not determine where its target stands") from error
    return np.asarray(equations.shared - equations.border[0].T @ of_pose)


@dataclass(frozen=True, slots=True, eq=False)
class SheetDoubt:
    """What is not known of the sheet over a field of pixels.

    Attributes
    ----------
    sensor
        Where the equations are linear.
    pixels_px
        Shape (N, 2), the field.
    information
        Shape (9, 9), of camera and sheet, all views together.
    """

    sensor: LaserSensor
    pixels_px: FloatArray
    information: FloatArray
    _squares: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        size = (_LAYOUT.size, _LAYOUT.size)
        object.__setattr__(self, "information", frozen(self.information, size, "information"))
        object.__setattr__(self, "_squares", _squares_over(self.sensor, self.pixels_px))

    @classmethod
    def of(cls, sensor: LaserSensor, pixels_px: FloatArray, told: Sequence[FloatArray]) -> Self:
        """Put together what views tell; without any, next to nothing is known."""
        return cls(sensor, pixels_px, np.sum([_hardly_anything(sensor), *told], axis=0))

    def sigma_mm(self, more: FloatArray | float = 0.0) -> float:
        """Return the RMS over the field of a point's standard deviation, mm.

        Parameters
        ----------
        more
            What another view would tell, shape (9, 9).
        """
        scale = 1.0 / np.sqrt(np.diag(self.information))
        total = (self.information + more) * np.outer(scale, scale)
        covariance = np.linalg.inv(total) * np.outer(scale, scale)
        return float(np.sqrt(np.sum(self._squares * covariance)))


def _squares_over(sensor: LaserSensor, pixels_px: FloatArray) -> FloatArray:
    """Return the mean over a field of J^T J, J = d(point)/d(camera and sheet), shape (9, 9)."""
    state = Estimate.start(sensor.camera, sensor.plane, [])
    _, by_sensor = sensor.location_jacobians(pixels_px)
    by_free = by_sensor @ _LAYOUT.sensor_from_global(state)
    by_free = by_free[np.isfinite(by_free).all(axis=(1, 2))]
    return np.asarray(np.einsum("nij,nik->jk", by_free, by_free) / max(len(by_free), 1))


def _hardly_anything(sensor: LaserSensor) -> FloatArray:
    """Return the information of a glance at the station: what keeps the first steps finite."""
    camera = sensor.camera
    sigmas = np.array([
        _FOCAL_PART * camera.fx,
        _FOCAL_PART * camera.fy,
        _CENTRE_PART * camera.width,
        _CENTRE_PART * camera.height,
        _DISTORTION,
        _DISTORTION,
        _ANGLE_RAD,
        _ANGLE_RAD,
        _OFFSET_PART * sensor.plane.offset_mm,
    ])
    return np.diag(sigmas**-2.0)
