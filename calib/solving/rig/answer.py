"""What the calibration of a rig returns: the rig, what it rests on, and how the solve ended."""

from collections.abc import Mapping
from dataclasses import dataclass

from calib.arrays import FloatArray
from calib.calibration import SolvedView, Termination
from calib.rig import Rig
from calib.rigid import RigidTransform
from calib.views import View


@dataclass(frozen=True, slots=True, eq=False)
class SolvedRigView:
    """One picture of one showing after the solve.

    Attributes
    ----------
    showing, sensor, board
        Whose picture, and of which board.
    quarters
        By how many quarter turns its numbering was off that of the board.
    solved
        The pose of the board, and what became of its points as the board numbers them; or why the
        picture was left out.
    seen
        What was seen in it, its points in the order of those solved; numbered as they came.
    """

    showing: str
    sensor: str
    board: str
    quarters: int
    solved: SolvedView
    seen: View


@dataclass(frozen=True, slots=True, eq=False)
class SolvedBoard:
    """One board of the target.

    Attributes
    ----------
    name
        Of the board.
    target_from_board
        Where it stands on the target, whose frame is that of the first board.
    covariance
        Shape (6, 6), of a small turn (rad) and a shift (mm) of it, along the target's axes.
    dot_shift_mm
        Shape (N, 3), how far each point was found off its place.
    sigma_mm, found_sigma_mm
        How far they were told to be, along each axis, and how far they seem to be.
    """

    name: str
    target_from_board: RigidTransform
    covariance: FloatArray
    dot_shift_mm: FloatArray
    sigma_mm: float
    found_sigma_mm: float


@dataclass(frozen=True, slots=True)
class SensorFit:
    """How the pictures of one sensor fit.

    Attributes
    ----------
    views, paired
        Pictures used, and how many of them beside one of another sensor.
    rms_dots_px, rms_stripe_px
        Root mean square deviations of the used points; a dot's by its length, a stripe point's
        along its normal.
    sigma_scale_dots, sigma_scale_stripe
        Actual over predicted scatter; 0 of a stripe that was not seen.
    outlier_fraction_dots, outlier_fraction_stripe
        Share of points that the robust model counts as outliers.
    """

    views: int
    paired: int
    rms_dots_px: float
    rms_stripe_px: float
    sigma_scale_dots: float
    sigma_scale_stripe: float
    outlier_fraction_dots: float
    outlier_fraction_stripe: float


@dataclass(frozen=True, slots=True, eq=False)
class RigReach:
    """How well the points of one sensor are known in the frame of the anchor's camera.

    Attributes
    ----------
    sigma_mm
        One standard deviation along the worst direction, root mean square over the part of the
        sheet that the showings lit; the sensor's own doubt included.
    direction
        That direction, unit, shape (3,), frame of the anchor's camera.
    """

    sigma_mm: float
    direction: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RigCalibration:
    """Sensors solved into one rig.

    Attributes
    ----------
    rig
        In the frame of the anchor's camera; the sensors as these pictures and what was known of
        them before tell together.
    anchor
        The sensor whose camera carries the frame.
    boards, views
        The target's boards; every picture given.
    left_out
        Why whole showings were left out, by name.
    fits, reach
        By sensor; `reach` of all but the anchor.
    rms_dots_px, rms_stripe_px
        Over all sensors.
    termination, iterations, cost
        How the solve ended; cost is half the sum of squares, each over its scaled sigma, with the
        priors.
    warnings
        What the reader should know.
    """

    rig: Rig
    anchor: str
    boards: tuple[SolvedBoard, ...]
    views: tuple[SolvedRigView, ...]
    left_out: Mapping[str, str]
    fits: Mapping[str, SensorFit]
    reach: Mapping[str, RigReach]
    rms_dots_px: float
    rms_stripe_px: float
    termination: Termination
    iterations: int
    cost: float
    warnings: tuple[str, ...]
