"""What a decision on a new calibration rests on."""

import math
from dataclasses import asdict, dataclass, field

from measure import PieceVerdict


@dataclass(frozen=True, slots=True)
class Difference:
    """How far the new calibration and the one in force place the pixels of the working volume.

    Attributes
    ----------
    rms_mm, largest_mm
        Of the differences; NaN where they see no part of the sheet in common.
    largest_at_px
        Where (u, v).
    expected_mm
        RMS difference that both covariances together expect of a sensor at rest.
    present_sigma_mm, new_sigma_mm
        What each of them contributes to it.
    """

    rms_mm: float
    largest_mm: float
    largest_at_px: tuple[float, float]
    expected_mm: float
    present_sigma_mm: float
    new_sigma_mm: float


@dataclass(frozen=True, slots=True)
class NewCalibration:
    """How good a new calibration is by itself.

    Attributes
    ----------
    failed_gates
        Of its own quality.
    poses
        Used, of the target.
    """

    poses: int
    rms_dots_px: float
    rms_stripe_px: float
    pictures_age_h: float
    failed_gates: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PieceFindings:
    """What the reference piece says of both calibrations; None where it was not seen.

    Attributes
    ----------
    required
        Whether nothing comes into force by itself without it.
    """

    by_new: PieceVerdict | None = None
    by_present: PieceVerdict | None = None
    required: bool = False

    @property
    def confirms_drift(self) -> bool:
        """Whether it comes out right with the new calibration alone."""
        return self.by_new is PieceVerdict.TRUE and self.by_present is PieceVerdict.DRIFTED


@dataclass(frozen=True, slots=True)
class Evidence:
    """Everything a decision rests on.

    Attributes
    ----------
    new
        None where there is none.
    unsolved
        Why there is none.
    sheet
        Of the sheets alone, seen through the camera in force: it tells of motions ten times
        smaller than the whole does. None where no calibration was in force.
    whole
        Of sheets and cameras together.
    present_age_days
        Since the calibration in force was made.
    unchecked_days
        Since the sensor was last found good.
    drifting
        Whether the last recalibration against the one in force found a drift.
    confirmed
        Recalibrations in a row before this one that found a drift, and agree with it.
    """

    new: NewCalibration | None = None
    unsolved: str | None = None
    sheet: Difference | None = None
    whole: Difference | None = None
    piece: PieceFindings = field(default_factory=PieceFindings)
    present_age_days: float | None = None
    unchecked_days: float | None = None
    drifting: bool = False
    confirmed: int = 0

    @property
    def figures(self) -> dict[str, float]:
        """The figures to keep with the decision."""
        told: dict[str, object] = {"present_age_days": self.present_age_days}
        if self.new is not None:
            told |= asdict(self.new)
        for name, difference in (("sheet", self.sheet), ("whole", self.whole)):
            if difference is not None:
                told |= {f"{name}_{key}": value for key, value in asdict(difference).items()}
        return {
            name: float(value)
            for name, value in told.items()
            if isinstance(value, int | float) and math.isfinite(value)
        }
