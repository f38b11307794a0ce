"""What every method is given, and what it gives back: one interface for all of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.calibration import CameraRole, SolveReport
from calib.camera import CameraModel
from calib.observations import Observations
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.start import has_stripe, start_plane, start_pose, stripe_in_space
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
        First cam_from_board of each view.
    plane
        A first light plane.
    stripe_in
        Shape (M,), the views with a stripe that agrees with it.
    """

    views: tuple[View, ...]
    target: Target
    observations: Observations
    camera: CameraModel
    role: CameraRole
    poses: tuple[RigidTransform, ...]
    plane: LightPlane
    stripe_in: BoolArray

    @classmethod
    def of(
        cls, views: Sequence[View], target: Target, camera: CameraModel, role: CameraRole
    ) -> "Prepared":
        """Find poses and a first plane.

        Parameters
        ----------
        views
            Usable ones; at least two with a stripe, whose points suffice.
        target, camera, role
            See the class.

        Raises
        ------
        Degenerate
            If the stripes do not single out a plane.
        """
        poses = tuple(start_pose(view, target, camera) for view in views)
        striped = [index for index, view in enumerate(views) if has_stripe(view)]
        ends = [
            stripe_in_space(stripe, camera, poses[index])
            for index in striped
            if (stripe := views[index].stripe) is not None
        ]
        first = start_plane(np.array(ends))
        stripe_in = np.zeros(len(views), dtype=bool)
        stripe_in[striped] = first.agreeing
        observations = Observations.of(views, target)
        return cls(tuple(views), target, observations, camera, role, poses, first.plane, stripe_in)


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
        used = self.deviation_px[self.used]
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
