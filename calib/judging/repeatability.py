"""How far calibrations from parts of the same pictures scatter: the paper's Fig. 10."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, read_only
from calib.calibration import Method
from calib.camera import CameraModel
from calib.compare import pixel_grid
from calib.errors import CalibError, TooFewViews
from calib.sensor import LaserSensor
from calib.solving.calibrate import calibrate
from calib.solving.start import has_stripe
from calib.target import Target
from calib.views import View

_LEAST_TAKEN = 2
_FEWEST_SOLVED = 2


@dataclass(frozen=True, slots=True, eq=False)
class Repeatability:
    """Calibrations from random parts of the pictures.

    Attributes
    ----------
    method
        How they were solved.
    coefficients
        Shape (D, 4), (a, b, c, d) of each draw that was solved.
    sheet_spread_mm
        Root mean square, over draws and field, of the distance of a point on the sheet from its
        mean over the draws.
    expected_spread_mm
        The same as the covariances of the calibrations predict it.
    refusals
        Reasons of the draws that were not solved.
    """

    method: Method
    coefficients: FloatArray
    sheet_spread_mm: float
    expected_spread_mm: float
    refusals: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", read_only(self.coefficients))

    @property
    def mean(self) -> FloatArray:
        """Mean of (a, b, c, d), shape (4,)."""
        return np.asarray(self.coefficients.mean(axis=0))

    @property
    def spread(self) -> FloatArray:
        """Standard deviation of (a, b, c, d) over the draws, shape (4,)."""
        return np.asarray(self.coefficients.std(axis=0, ddof=1))


def judge_repeatability(
    views: Sequence[View],
    target: Target,
    rng: np.random.Generator,
    *,
    width: int,
    height: int,
    camera: CameraModel | None = None,
    method: Method = Method.JOINT,
    draws: int = 20,
    take: int = 10,
) -> Repeatability:
    """Calibrate from parts of the views, drawn without putting back, and tell the scatter.

    Parameters
    ----------
    views, target, width, height, camera, method
        As for `calib.calibrate`; views without a stripe are not drawn.
    rng
        Draws the parts.
    draws, take
        How many parts, of how many views each.

    Raises
    ------
    TooFewViews
        If there are fewer views with a stripe than are to be taken, or fewer than two parts could
        be solved.
    ValueError
        If `draws` or `take` is less than 2.

    Notes
    -----
    Two parts of the same views share some, so they scatter less than two sets of new pictures
    would: a mean of n of N, drawn without putting back, has 1 - n/N of the variance that n new
    ones give, on average over sets of N. `expected_spread_mm` has that factor in it. Where the
    camera is given, its own doubt is common to all draws and does not show in their scatter.
    """
    if not (draws >= _FEWEST_SOLVED and take >= _LEAST_TAKEN):
        raise ValueError(f"draws and take must be at least 2, got {draws} and {take}")
    striped = [view for view in views if has_stripe(view)]
    if len(striped) < take:
        raise TooFewViews(
            f"{len(striped)} pictures with target and stripe, {take} are to be drawn of them; add "
            "pictures or draw fewer"
        )
    sensors: list[LaserSensor] = []
    refusals: list[str] = []
    for _ in range(draws):
        part = [striped[index] for index in rng.choice(len(striped), take, replace=False)]
        try:
            answer = calibrate(
                part, target, width=width, height=height, camera=camera, method=method
            )
            sensors.append(answer.sensor)
        except CalibError as error:
            refusals.append(str(error))
    if len(sensors) < _FEWEST_SOLVED:
        raise TooFewViews(
            f"{len(sensors)} of {draws} parts of {take} pictures could be solved ({refusals[0]}); "
            "draw more pictures at a time"
        )
    shared = np.sqrt(1.0 - take / len(striped))
    field_px = _seen_field(striped, width, height)
    return Repeatability(
        method=method,
        coefficients=np.array([sensor.plane.coefficients for sensor in sensors]),
        sheet_spread_mm=_spread_mm(sensors, field_px),
        expected_spread_mm=float(shared * _expected_mm(sensors, field_px, camera)),
        refusals=tuple(refusals),
    )


def _seen_field(views: Sequence[View], width: int, height: int) -> FloatArray:
    """Return pixels within the box around all stripe points: where the sheet was seen."""
    seen = np.vstack([view.stripe.centre_px for view in views if view.stripe is not None])
    pixels = pixel_grid(width, height)
    inside = ((pixels >= seen.min(axis=0)) & (pixels <= seen.max(axis=0))).all(axis=1)
    return np.asarray(pixels[inside]) if inside.any() else seen


def _spread_mm(sensors: Sequence[LaserSensor], field_px: FloatArray) -> float:
    points = np.array([sensor.locate(field_px) for sensor in sensors])
    off = points - points.mean(axis=0)
    per_point = (off**2).sum(axis=(0, 2)) / (len(sensors) - 1)
    return float(np.sqrt(np.nanmean(per_point)))


def _expected_mm(
    sensors: Sequence[LaserSensor], field_px: FloatArray, camera: CameraModel | None
) -> float:
    """Return the RMS length of the located points' predicted deviations over draws and field."""
    variances = []
    for sensor in sensors:
        own = sensor
        if camera is not None:
            covariance = sensor.covariance.copy()
            covariance[:9] = covariance[:, :9] = 0.0
            own = LaserSensor(sensor.camera, sensor.plane, covariance)
        covariance_mm2 = own.location_covariance(field_px)
        variances.append(np.nanmean(np.trace(covariance_mm2, axis1=1, axis2=2)))
    return float(np.sqrt(np.mean(variances)))
