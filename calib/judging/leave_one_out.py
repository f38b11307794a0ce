"""Each pose measured by a calibration that has not seen it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, read_only
from calib.calibration import Method
from calib.camera import CameraModel
from calib.errors import CalibError
from calib.lines import fit_line_robustly
from calib.sensor import LaserSensor
from calib.solving.calibrate import calibrate
from calib.solving.prepared import solve_dots
from calib.solving.start import has_stripe, why_unusable
from calib.target import Target
from calib.views import View


@dataclass(frozen=True, slots=True, eq=False)
class LeftOutPose:
    """One pose against the calibration by the others.

    Attributes
    ----------
    name
        Name of the view.
    errors_mm
        Shape (N,), of each point on the line of its stripe: how much farther along its ray the
        sensor places it than the pose's own board does.
    reason
        Why there are none; empty where there are.
    """

    name: str
    errors_mm: FloatArray
    reason: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "errors_mm", read_only(self.errors_mm))

    @property
    def rms_mm(self) -> float:
        """Root mean square of the errors; NaN where there are none."""
        return float(np.sqrt(np.mean(self.errors_mm**2))) if len(self.errors_mm) else float("nan")

    @property
    def mean_mm(self) -> float:
        """Mean of the errors: what the pose as a whole is off by; NaN where there are none."""
        return float(self.errors_mm.mean()) if len(self.errors_mm) else float("nan")


def judge_leaving_out(
    views: Sequence[View],
    target: Target,
    *,
    width: int,
    height: int,
    camera: CameraModel | None = None,
    method: Method = Method.JOINT,
) -> tuple[LeftOutPose, ...]:
    """Calibrate without each view in turn, and measure its stripe by what the others say.

    Parameters
    ----------
    views, target, width, height, camera, method
        As for `calib.calibrate`. Without a camera, it too is estimated from the other views.

    Returns
    -------
    poses
        One for every view, in order; a view that cannot be measured says why.

    Notes
    -----
    The truth is the view's own board, whose pose its dots tell. A ray meets the board at B and
    the sheet at X; the error is the signed length of X - B. A point's own noise is in it.
    """
    return tuple(
        _left_out(
            view,
            [*views[:index], *views[index + 1 :]],
            target,
            (width, height),
            camera,
            method,
        )
        for index, view in enumerate(views)
    )


def _left_out(
    view: View,
    others: Sequence[View],
    target: Target,
    size: tuple[int, int],
    camera: CameraModel | None,
    method: Method,
) -> LeftOutPose:
    reason = why_unusable(view, target) or ("" if has_stripe(view) else "no stripe across it")
    if reason:
        return LeftOutPose(view.name, np.empty(0), reason)
    try:
        answer = calibrate(
            others, target, width=size[0], height=size[1], camera=camera, method=method
        )
        return LeftOutPose(view.name, _errors_mm(view, target, answer.sensor))
    except CalibError as error:
        return LeftOutPose(view.name, np.empty(0), str(error))


def _errors_mm(view: View, target: Target, sensor: LaserSensor) -> FloatArray:
    if view.stripe is None:
        return np.empty(0)
    (cam_from_board,) = solve_dots([view], target, sensor.camera).estimate.poses
    rays = sensor.camera.rays(view.stripe.centre_px)
    rays = rays[fit_line_robustly(rays[:, :2])[1]]
    normal = cam_from_board.rotation[:, 2]
    on_board = rays * (normal @ cam_from_board.translation_mm / (rays @ normal))[:, None]
    further = sensor.plane.intersect(rays)[:, 2] / on_board[:, 2] - 1.0
    return np.asarray(further * np.linalg.norm(on_board, axis=1))
