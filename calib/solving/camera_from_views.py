"""A camera from views of a target: Zhang's closed form to start, then maximum likelihood."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.calibration import CameraRole, SolveReport
from calib.camera import PARAMETERS, CameraModel
from calib.errors import Degenerate
from calib.homography import pose_from_homography
from calib.rigid import RigidTransform
from calib.solving.joint.method import camera_of, dots_answer, report_of, scale_warnings
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.problem import Problem
from calib.solving.joint.solve import solve
from calib.solving.observations import Observations
from calib.solving.prepared import PointsAnswer
from calib.solving.start import picture_homography
from calib.solving.supported_terms import with_supported_terms
from calib.solving.zhang import camera_from_homographies
from calib.target import Target
from calib.views import View

# Always estimated: focal lengths, principal point, k1, k2.
_BASIC = tuple(PARAMETERS.index(name) for name in ("fx", "fy", "cx", "cy", "k1", "k2"))
# Relative standard deviations of the focal length: above the first the answer says so, above the
# second there is none.
_DOUBTFUL_FOCAL, _HOPELESS_FOCAL = 0.01, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class CameraAnswer:
    """What a solve for the camera found.

    Attributes
    ----------
    camera, poses, dots
        The camera with its covariance, the poses of the views, what became of the dots.
    report, warnings
        How the solve ended; what the reader should know.
    """

    camera: CameraModel
    poses: tuple[RigidTransform, ...]
    dots: PointsAnswer
    report: SolveReport
    warnings: tuple[str, ...]


def solve_camera(views: Sequence[View], target: Target, *, width: int, height: int) -> CameraAnswer:
    """Solve camera and poses from the dots of usable views.

    Raises
    ------
    Degenerate
        If the views leave the focal length undetermined.
    NotConverged
        If the solve does not end.
    """
    bare = [replace(view, stripe=None) for view in views]
    homographies = [picture_homography(view, target) for view in bare]
    parameters = camera_from_homographies(homographies, width=width, height=height)
    camera = CameraModel.from_parameters(parameters, width=width, height=height)
    to_rays = np.linalg.inv(camera.matrix)
    poses = [pose_from_homography(to_rays @ homography) for homography in homographies]
    problem = Problem(
        Observations.of(bare, target),
        Layout(_BASIC, plane=False),
        prior=None,
        stripe_in=np.zeros(len(bare), dtype=bool),
        on_line=np.zeros(0, dtype=bool),
    )
    solution = solve(problem, Estimate.start(camera, None, poses), near=False)
    problem, solution = with_supported_terms(problem, solution)
    answer = camera_of(solution, problem.layout, camera)
    report = report_of(problem, solution, CameraRole.ESTIMATED)
    return CameraAnswer(
        camera=answer,
        poses=tuple(solution.estimate.poses),
        dots=dots_answer(problem, solution),
        report=report,
        warnings=(*_focal_warnings(answer), *scale_warnings(report)),
    )


def _focal_warnings(camera: CameraModel) -> tuple[str, ...]:
    sigma = float(np.sqrt(camera.covariance[0, 0]))
    if not sigma <= _HOPELESS_FOCAL * camera.fx:
        raise Degenerate(
            f"the focal length cannot be told from these pictures (fx {camera.fx:.0f} px, standard "
            f"deviation {sigma:.0f} px); tilt the target by 20 degrees or more about both axes, or "
            "give the camera"
        )
    if sigma > _DOUBTFUL_FOCAL * camera.fx:
        return (
            f"fx is known to {sigma:.0f} px only; more pictures with the target tilted about both "
            "axes would tell it better",
        )
    return ()
