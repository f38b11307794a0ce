"""Limits of service: which values raise an alarm."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from measure.quantities import Alarm, Quantity


@dataclass(frozen=True, slots=True)
class Limit:
    """The range a value may have, mm, and how near its ends the warning starts."""

    low_mm: float = float("-inf")
    high_mm: float = float("inf")
    warn_within_mm: float = 0.5

    def __post_init__(self) -> None:
        if not (self.low_mm < self.high_mm and self.warn_within_mm >= 0.0):
            raise ValueError(
                f"a limit needs low < high and a warning margin of 0 or more, got {self!r}"
            )

    def judge(self, value_mm: float, u95_mm: float) -> Alarm:
        """Judge a value; one whose interval reaches over the limit is a warning at least."""
        room = min(value_mm - self.low_mm, self.high_mm - value_mm)
        if room < 0.0:
            return Alarm.ALARM
        return Alarm.WARNING if room < max(self.warn_within_mm, u95_mm) else Alarm.NONE


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """The limits in force: a regime's name, and a limit for each quantity that has one."""

    regime: str
    of: Mapping[Quantity, Limit]

    def __post_init__(self) -> None:
        object.__setattr__(self, "of", MappingProxyType(dict(self.of)))

    @classmethod
    def default(cls) -> "Limits":
        """Make limits from practice; they are to be confirmed by the user's own regulations.

        TSI wheels over 840 mm: Sd 22 to 33, Sh 27.5 to 36, qR from 6.5. Chinese freight: flange
        at 12 mm from 23, tread wear to 8. A hollow of 2 mm is a common limit.
        """
        return cls(
            "practice",
            {
                Quantity.FLANGE_HEIGHT: Limit(27.5, 36.0),
                Quantity.FLANGE_THICKNESS_10: Limit(22.0, 33.0),
                Quantity.FLANGE_THICKNESS_12: Limit(low_mm=23.0),
                Quantity.FLANGE_GRADIENT_QR: Limit(low_mm=6.5),
                Quantity.TREAD_WEAR: Limit(high_mm=8.0),
                Quantity.TREAD_WEAR_AT_70: Limit(high_mm=8.0),
                Quantity.TREAD_WEAR_MAX: Limit(high_mm=8.0),
                Quantity.HOLLOW_DEPTH: Limit(high_mm=2.0),
            },
        )

    def judge(self, quantity: Quantity, value_mm: float, u95_mm: float) -> Alarm:
        """Judge a value of a quantity; one without a limit raises nothing."""
        limit = self.of.get(quantity)
        return limit.judge(value_mm, u95_mm) if limit is not None else Alarm.NONE
