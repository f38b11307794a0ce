"""When pictures of a session are enough: by the gates of the solve, and what they leave open."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from calib import Calibration, Coverage, FloatArray
from station.pipeline import LARGEST_SHEET_SIGMA_MM, LARGEST_SIGMA_SCALE

LARGEST_FOCAL_PART = 0.01
"""Relative standard deviation of the focal length from which a solve warns of it."""
LEAST_COVERED = 0.75
"""Part of the field's cells that must have had a dot: beyond the dots the lens is extrapolated,
which no covariance tells; a cell without any between others is not."""


class Demand(StrEnum):
    """What is asked of the pictures together."""

    POSES = "poses"
    """Poses that show target and stripe."""
    COVERED = "covered"
    """Part of the field in which dots have been seen."""
    FOCAL = "focal"
    """Relative standard deviation of the focal length: what tilts are for."""
    SHEET = "sheet"
    """Standard deviation of the sheet over the whole field, mm."""
    DOTS = "dots"
    """Scatter of the dots, times the predicted."""
    STRIPE = "stripe"
    """Scatter of the stripe's points, times the predicted."""


@dataclass(frozen=True, slots=True)
class Criterion:
    """One demand, how far it is met, and its limit.

    Attributes
    ----------
    value
        None where it cannot be told yet.
    at_least
        Whether the limit is a lower one.
    """

    demand: Demand
    value: float | None
    limit: float
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether the demand is met."""
        if self.value is None:
            return False
        return self.value >= self.limit if self.at_least else self.value <= self.limit


@dataclass(frozen=True, slots=True)
class Demands:
    """The limits.

    Raises
    ------
    ValueError
        If fewer than three poses are asked for: those fix no sheet.
    """

    fewest_poses: int

    def __post_init__(self) -> None:
        if not self.fewest_poses >= 3:
            raise ValueError(f"{self.fewest_poses} poses; allowed: at least 3")

    def criteria(
        self, poses: int, trial: Calibration | None, coverage: Coverage | None, field_px: FloatArray
    ) -> tuple[Criterion, ...]:
        """Hold what there is against the limits.

        Parameters
        ----------
        poses
            That show target and stripe.
        trial
            What a solve of the pictures so far gives; None where there is none yet.
        coverage
            Of the field by dots; None where the field is not known yet.
        field_px
            Shape (N, 2), the field.
        """
        share = None if coverage is None else coverage.share
        return (
            Criterion(Demand.POSES, poses, self.fewest_poses, at_least=True),
            Criterion(Demand.COVERED, share, LEAST_COVERED, at_least=True),
            *_of_trial(trial, field_px),
        )


def _of_trial(trial: Calibration | None, field_px: FloatArray) -> Iterator[Criterion]:
    focal = sheet_mm = dots = stripe = None
    if trial is not None:
        camera = trial.sensor.camera
        focal = _told(math.sqrt(camera.covariance[0, 0]) / camera.fx)
        sheet_mm = _told(rms_mm(trial.sensor.sigma_on_sheet(field_px)))
        dots, stripe = trial.solve.sigma_scale_dots, trial.solve.sigma_scale_stripe
    yield Criterion(Demand.FOCAL, focal, LARGEST_FOCAL_PART)
    yield Criterion(Demand.SHEET, sheet_mm, LARGEST_SHEET_SIGMA_MM)
    yield Criterion(Demand.DOTS, dots, LARGEST_SIGMA_SCALE)
    yield Criterion(Demand.STRIPE, stripe, LARGEST_SIGMA_SCALE)


def rms_mm(sigma_mm: FloatArray) -> float:
    """Return the root mean square of what is finite; NaN of nothing."""
    finite = sigma_mm[np.isfinite(sigma_mm)]
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else math.nan


def _told(value: float) -> float | None:
    return value if math.isfinite(value) else None
