"""What a calibration returns: the answer, what it rests on, and how the solve ended."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from calib.arrays import BoolArray, FloatArray, frozen, read_only
from calib.camera import CameraModel
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.views import Cause, View


class Method(StrEnum):
    """The ways to solve the light plane."""

    PREPLANAR = "preplanar"
    DEVIATION = "deviation"
    JOINT = "joint"


class Termination(StrEnum):
    """Why a solve stopped."""

    CONVERGED = "converged"
    CLOSED_FORM = "closed form"
    STEP_LIMIT = "step limit"


class CameraRole(StrEnum):
    """What a solve did with the camera."""

    HELD = "held"
    PRIOR = "estimated with a prior"
    ESTIMATED = "estimated"


@dataclass(frozen=True, slots=True)
class SolveReport:
    """How a solve ended.

    Attributes
    ----------
    termination, iterations
        Why it stopped and after how many steps.
    cost
        Half the sum of squared, robustly weighted residuals, each over its scaled sigma.
    sigma_scale_dots, sigma_scale_stripe
        Actual over predicted scatter; 1 where the sigmas are true. The stripe's is 0 where no
        stripe took part.
    outlier_fraction_dots, outlier_fraction_stripe
        Share of points that the robust model counts as outliers.
    camera
        What was done with the camera.
    on_bound
        Names of parameters that ended on a bound.
    """

    termination: Termination
    iterations: int
    cost: float
    sigma_scale_dots: float
    sigma_scale_stripe: float
    outlier_fraction_dots: float
    outlier_fraction_stripe: float
    camera: CameraRole
    on_bound: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SolvedPoints:
    """The points of one view after the solve, in the order of the view.

    Attributes
    ----------
    corrected_px
        Shape (N, 2); deviation = observed - corrected. A stripe point moves along its normal only.
    used
        Shape (N,), the point took part in the answer.
    cause
        N entries: why a point is doubtful or was not used.
    """

    corrected_px: FloatArray
    used: BoolArray
    cause: tuple[Cause, ...]

    def __post_init__(self) -> None:
        count = len(self.cause)
        corrected = frozen(self.corrected_px, (count, 2), "corrected_px")
        object.__setattr__(self, "corrected_px", corrected)
        used = read_only(np.asarray(self.used, dtype=bool))
        if used.shape != (count,):
            raise ValueError(f"used must have shape ({count},), got {used.shape}")
        object.__setattr__(self, "used", used)

    def __len__(self) -> int:
        return len(self.cause)


@dataclass(frozen=True, slots=True, eq=False)
class SolvedView:
    """One view after the solve.

    Attributes
    ----------
    name
        Name of the view.
    cam_from_board
        The pose; None where the view was left out.
    dots, stripe
        The corrected points; None where the view was left out, or has no stripe.
    left_out
        Why the whole view was left out; empty where it was used.
    """

    name: str
    cam_from_board: RigidTransform | None
    dots: SolvedPoints | None
    stripe: SolvedPoints | None
    left_out: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class CameraCalibration:
    """A camera solved from views of a target.

    Attributes
    ----------
    camera
        Intrinsics with their covariance; distortion terms the data do not support are 0 and held.
    rms_dots_px
        Root mean square length of the deviations of the used dots.
    views, solve, warnings
        Per view, in the order given; how the solve ended; what the reader should know.
    """

    camera: CameraModel
    rms_dots_px: float
    views: tuple[SolvedView, ...]
    solve: SolveReport
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A laser sensor solved from views of a target crossed by its stripe.

    Attributes
    ----------
    sensor
        Camera, light plane and their joint covariance.
    method
        How it was solved.
    rms_dots_px
        Root mean square length of the deviations of the used dots.
    rms_stripe_px
        Root mean square deviation of the used stripe points, along their normals.
    views, solve, warnings
        Per view, in the order given; how the solve ended; what the reader should know.
    seen
        The views as they were used: where a picture shows several lines, its stripe is the one
        that lies on the light plane of the others.
    """

    sensor: LaserSensor
    method: Method
    rms_dots_px: float
    rms_stripe_px: float
    views: tuple[SolvedView, ...]
    solve: SolveReport
    warnings: tuple[str, ...]
    seen: tuple[View, ...]
