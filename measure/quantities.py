"""What is read off a wheel, how sure each reading is, and what it means for service."""

from dataclasses import dataclass
from enum import StrEnum


class Quantity(StrEnum):
    """The readings of one wheel, mm; the names are those of the results file."""

    FLANGE_HEIGHT = "flange_height"
    """Sh: flange tip minus tread height at d = 70."""
    FLANGE_THICKNESS_10 = "flange_thickness_10"
    """Sd: distance of the flange face from the flange back, 10 mm above the tread at d = 70."""
    FLANGE_THICKNESS_12 = "flange_thickness_12"
    """The same 12 mm above."""
    FLANGE_GRADIENT_QR = "flange_gradient_qr"
    """qR: lateral distance of the face points at tread + 10 and at tip - 2."""
    TREAD_WEAR = "tread_wear"
    """Sh minus the reference's Sh: the datum is the flange tip, which does not wear."""
    TREAD_WEAR_AT_70 = "tread_wear_at_70"
    """Reference minus measured height at d = 70, the two aligned at flange back and tip."""
    TREAD_WEAR_MAX = "tread_wear_max"
    """The greatest such difference over the running tread."""
    HOLLOW_DEPTH = "hollow_depth"
    """Depth of the tread's hollow below the level of its field-side high point."""
    DIAMETER = "diameter"
    """Twice the radius at the tape circle; only where several sheets tell it."""

    @property
    def grows_with_wear(self) -> bool:
        """Whether wear makes it greater; it thins the flange, steepens its face, takes radius."""
        return self not in {
            Quantity.DIAMETER,
            Quantity.FLANGE_THICKNESS_10,
            Quantity.FLANGE_THICKNESS_12,
            Quantity.FLANGE_GRADIENT_QR,
        }


OF_A_PROFILE = tuple(quantity for quantity in Quantity if quantity is not Quantity.DIAMETER)
"""What one profile of a wheel can show."""

NEEDS_BACK = frozenset({
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
})
"""What is not given where the flange back is not seen, unless the user allows it."""

ASSUMED_BACK_SIGMA_MM = 0.5
"""What a flange back that is only inferred may be off."""


class Status(StrEnum):
    """How a value was come by."""

    OK = "ok"
    EXTRAPOLATED = "extrapolated"
    REFERENCE_ASSUMED = "reference_assumed"
    MISSING = "missing"


class Alarm(StrEnum):
    """What a value means against the limits in force; ``UNKNOWN`` is a value that is missing."""

    NONE = "none"
    WARNING = "warning"
    ALARM = "alarm"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Reading:
    """One quantity of one wheel.

    Attributes
    ----------
    value
        mm; None where the status is ``missing``.
    u95
        Half-width of the 95 % interval, mm; None with the value.
    status
        How the value was come by.
    alarm
        What it means against the limits.
    """

    value: float | None
    u95: float | None
    status: Status
    alarm: Alarm

    def __post_init__(self) -> None:
        missing = self.status is Status.MISSING
        if missing != (self.value is None) or missing != (self.u95 is None):
            raise ValueError(
                f"a reading has value and u95, or is missing; got {self.value}, {self.u95}, "
                f"{self.status.value}"
            )
        if self.u95 is not None and not self.u95 >= 0.0:
            raise ValueError(f"u95 must not be negative, got {self.u95}")

    @classmethod
    def missing(cls) -> "Reading":
        """Make the reading of a quantity that was not seen."""
        return cls(None, None, Status.MISSING, Alarm.UNKNOWN)
