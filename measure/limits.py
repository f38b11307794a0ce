"""Limits of service: which values raise an alarm, and which changes."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from measure.quantities import Alarm, Quantity

JUMP_MM = 1.0
"""No regulation speaks of jumps; a wheel takes months to wear so much, a broken flange a moment."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The range a value may have, how near its worn end the warning starts, and what is a jump.

    Attributes
    ----------
    low_mm, high_mm
        Ends of the range.
    warn_within_mm
        A value this near the end that wear leads to is a warning.
    jump_mm
        A change beyond this from one pass to the next is an alarm of its own.
    """

    low_mm: float = float("-inf")
    high_mm: float = float("inf")
    warn_within_mm: float = 0.5
    jump_mm: float = JUMP_MM

    def __post_init__(self) -> None:
        if not (self.low_mm < self.high_mm and self.warn_within_mm >= 0.0):
            raise ValueError(
                f"a limit needs low < high and a warning margin of 0 or more, got {self!r}"
            )
        if not self.jump_mm > 0.0:
            raise ValueError(f"jump_mm must be positive, got {self.jump_mm!r}")

    def judge(self, value_mm: float, u95_mm: float, *, grows: bool) -> Alarm:
        """Judge a value; one whose interval reaches over the limit is a warning at least.

        Parameters
        ----------
        value_mm, u95_mm
            The value and the half-width of its 95 % interval.
        grows
            Whether wear makes the value greater; the margin counts at that end alone, as a new
            wheel may be near the other (a new LMA flange is 32.9 mm thick, the TSI allows 33).
        """
        below, above = value_mm - self.low_mm, self.high_mm - value_mm
        if min(below, above) < 0.0:
            return Alarm.ALARM
        worn = above if grows else below
        near = worn < self.warn_within_mm or min(below, above) < u95_mm
        return Alarm.WARNING if near else Alarm.NONE


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """The limits in force: a regime's name, and a limit for each quantity that has one.

    `back_to_back` is that of the distance between the flange backs of an axle, no quantity of a
    wheel; None where the regime has none.
    """

    regime: str
    of: Mapping[Quantity, Limit]
    back_to_back: Limit | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "of", MappingProxyType(dict(self.of)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Limits) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __reduce__(self) -> tuple[type["Limits"], tuple[str, dict[Quantity, Limit], Limit | None]]:
        # A read-only view of a mapping does not go to another process.
        return Limits, (self.regime, dict(self.of), self.back_to_back)

    @property
    def _content(self) -> tuple[str, frozenset[tuple[Quantity, Limit]], Limit | None]:
        return self.regime, frozenset(self.of.items()), self.back_to_back

    @classmethod
    def default(cls) -> "Limits":
        """Make limits from practice; they are to be confirmed by the user's own regulations."""
        return PRESETS["practice"]

    def judge(self, quantity: Quantity, value_mm: float, u95_mm: float) -> Alarm:
        """Judge a value of a quantity; one without a limit raises nothing."""
        limit = self.of.get(quantity)
        if limit is None:
            return Alarm.NONE
        return limit.judge(value_mm, u95_mm, grows=quantity.grows_with_wear)

    def judge_back_to_back(self, value_mm: float, u95_mm: float) -> Alarm:
        """Judge the distance between the flange backs of an axle."""
        if self.back_to_back is None:
            return Alarm.NONE
        return self.back_to_back.judge(value_mm, u95_mm, grows=True)


# The in-service limits of the TSI for locomotives and passenger vehicles, wheels over 840 mm in
# diameter (of 760 to 840 mm: Sd from 25; below: from 27.5), as EN 15313 measures them.
_TSI = {
    Quantity.FLANGE_HEIGHT: Limit(27.5, 36.0),
    Quantity.FLANGE_THICKNESS_10: Limit(22.0, 33.0),
    Quantity.FLANGE_GRADIENT_QR: Limit(low_mm=6.5),
}
# Chinese freight wagons, read with the type-4 wheel gauge: flange at 12 mm, tread wear by the tip.
_CHINA_FREIGHT = {
    Quantity.FLANGE_THICKNESS_12: Limit(low_mm=23.0),
    Quantity.TREAD_WEAR: Limit(high_mm=8.0),
}
# Both; the same 8 mm for tread wear read in its other two ways; a hollow of 2 mm, a common limit.
_PRACTICE = {
    **_TSI,
    **_CHINA_FREIGHT,
    Quantity.TREAD_WEAR_AT_70: Limit(high_mm=8.0),
    Quantity.TREAD_WEAR_MAX: Limit(high_mm=8.0),
    Quantity.HOLLOW_DEPTH: Limit(high_mm=2.0),
}

BACK_TO_BACK_TSI = Limit(1357.0, 1363.0, warn_within_mm=0.0)
"""Between the flange backs of an axle, in service on 1435 mm gauge, wheels over 840 mm in diameter
(of 760 to 840 mm: from 1358; below: from 1359). Wear does not change it: no end is the worn one."""

PRESETS: Mapping[str, Limits] = MappingProxyType({
    "practice": Limits("practice", _PRACTICE, BACK_TO_BACK_TSI),
    "tsi": Limits("tsi", _TSI, BACK_TO_BACK_TSI),
    "china_freight": Limits("china_freight", _CHINA_FREIGHT),
})
"""Regimes by name. Each is to be confirmed by the regulations its user is under."""
