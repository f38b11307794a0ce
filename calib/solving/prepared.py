"""What every method is given, and what it gives back: one interface for all of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.calibration import CameraRole, SolveReport
from calib.camera import CameraModel
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.solving.joint.discs import cross_matrices
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.problem import Problem, Solution
from calib.solving.joint.solve import solve
from calib.solving.observations import Observations
from calib.solving.start import StripeLine, has_stripe, start_plane, start_pose, stripe_line
from calib.target import Target
from calib.views import View


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """Usable views and where a solve begins with them.

    Attributes
    ----------
    views, target, observations
        M views, the target in them, their points as tables.
    camera, role
        The camera, and what may be done with it. Its free parameters are those with a variance.
    poses
        cam_from_board of each view, by its dots alone.
    plane
        A first light plane.
    stripe_in
        Shape (M,), the views with a stripe that agrees with it.
    on_line
        Shape (N,), the stripe points that lie on the line of their own view's stripe.
    """

    views: tuple[View, ...]
    target: Target
    observations: Observations
    camera: CameraModel
    role: CameraRole
    poses: tuple[RigidTransform, ...]
    plane: LightPlane
    stripe_in: BoolArray
    on_line: BoolArray

    @classmethod
    def of(
        cls,
        views: Sequence[View],
        target: Target,
        camera: CameraModel,
        role: CameraRole,
        near: Sequence[RigidTransform] = (),
    ) -> "Prepared":
        """Find poses and a first plane.

        Parameters
        ----------
        views
            Usable ones; at least two with a stripe, whose points suffice.
        target, camera, role
            See the class.
        near
            Poses of the views, where a solve of the camera left them.

        Raises
        ------
        Degenerate
            If the stripes do not single out a plane.
        """
        observations = Observations.of(views, target)
        dots_only = solve_dots(views, target, camera, near)
        poses = tuple(dots_only.estimate.poses)
        lines = {
            index: stripe_line(view.stripe, camera, poses[index])
            for index, view in enumerate(views)
            if view.stripe is not None and has_stripe(view)
        }
        own = list(lines)
        first = start_plane(
            np.array([line.ends_mm for line in lines.values()]),
            _middle_covariance(list(lines.values()), own, dots_only),
        )
        stripe_in = np.zeros(len(views), dtype=bool)
        stripe_in[own] = first.agreeing
        on_line = np.zeros(len(observations.stripe), dtype=bool)
        firsts = np.searchsorted(observations.stripe.view, own)
        for begin, line in zip(firsts, lines.values(), strict=True):
            on_line[begin : begin + len(line.agreeing)] = line.agreeing
        return cls(
            views=tuple(views),
            target=target,
            observations=observations,
            camera=camera,
            role=role,
            poses=poses,
            plane=first.plane,
            stripe_in=stripe_in,
            on_line=on_line,
        )


def solve_dots(
    views: Sequence[View],
    target: Target,
    camera: CameraModel,
    near: Sequence[RigidTransform] = (),
) -> Solution:
    """Find the most likely poses by the target's points alone, the camera held.

    The poses `near`, where given, are taken to be the answer already but for little.
    """
    bare = [replace(view, stripe=None) for view in views]
    problem = Problem(
        Observations.of(bare, target),
        Layout((), plane=False),
        prior=None,
        stripe_in=np.zeros(len(bare), dtype=bool),
        on_line=np.zeros(0, dtype=bool),
    )
    first = list(near) or [start_pose(view, target, camera) for view in bare]
    return solve(problem, Estimate.start(camera, None, first), near=bool(near))


def _middle_covariance(
    lines: Sequence[StripeLine], views: Sequence[int], dots_only: Solution
) -> FloatArray:
    """Return the covariance of each stripe's middle by its pose, camera frame, (M, 3, 3), mm^2."""
    middle = np.array([line.ends_mm for line in lines]).mean(axis=1)
    arm = middle - dots_only.estimate.translation_mm[views]
    shift = np.broadcast_to(np.eye(3), (len(arm), 3, 3))
    by_pose = np.concatenate([-cross_matrices(arm), shift], axis=2)
    return np.asarray(by_pose @ dots_only.covariance.views[views] @ by_pose.transpose(0, 2, 1))


@dataclass(frozen=True, slots=True, eq=False)
class PointsAnswer:
    """What became of the points of one kind, in the order of their table.

    Attributes
    ----------
    corrected_px
        Shape (N, 2).
    deviation_px
        Shape (N,), how far a point lies from the model: the length of a dot's deviation, a stripe
        point's along its normal.
    used
        Shape (N,).
    """

    corrected_px: FloatArray
    deviation_px: FloatArray
    used: BoolArray

    @property
    def rms_px(self) -> float:
        """Root mean square of the used deviations; 0 where none is used."""
        return rms_px([self])


def rms_px(parts: Sequence[PointsAnswer]) -> float:
    """Return the root mean square of all used deviations; 0 where none is used."""
    used = np.concatenate([part.deviation_px[part.used] for part in parts])
    return float(np.sqrt(np.mean(used**2))) if len(used) else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a method found.

    Attributes
    ----------
    camera, plane, poses
        The answer; the camera carries its own covariance.
    covariance
        Of the sensor, shape (13, 13).
    dots, stripe
        What became of the points.
    stripe_in
        Shape (M,), the views whose stripe was believed.
    report, warnings
        How the solve ended; what the reader should know.
    """

    camera: CameraModel
    plane: LightPlane
    poses: tuple[RigidTransform, ...]
    covariance: FloatArray
    dots: PointsAnswer
    stripe: PointsAnswer
    stripe_in: BoolArray
    report: SolveReport
    warnings: tuple[str, ...] = ()
