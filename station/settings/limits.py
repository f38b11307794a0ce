"""The `[limits]` of the settings file; `station.limits` makes of them what alarms follow."""

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from station.settings.section import Section


class RangeSettings(Section):
    """The range a value may have, mm; a missing end is none."""

    low: float | None = Field(default=None, allow_inf_nan=False)
    """Least value."""
    high: float | None = Field(default=None, allow_inf_nan=False)
    """Greatest value."""

    @model_validator(mode="after")
    def _some_value_is_allowed(self) -> Self:
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError(f"low {self.low:g} and high {self.high:g} allow nothing; low < high")
        return self


class LimitSettings(RangeSettings):
    """The limits of one quantity."""

    warn_within: float = Field(default=0.5, ge=0.0)
    """How near the worn end the warning starts, mm."""
    jump: float = Field(default=1.0, gt=0.0)
    """Change from one pass of a wheel to the next that is an alarm, mm; inf: none is."""


class LimitsSettings(Section):
    """What raises alarms: a regime, and the limits of single quantities that replace its own."""

    _NAMES: ClassVar[frozenset[str]] = frozenset({"preset", "regime"})

    preset: Literal["practice", "tsi", "china_freight"] = "practice"
    """The regime that limits not given here are taken from."""
    regime: str | None = Field(default=None, min_length=1, max_length=64)
    """Name of the regime, kept with each reading; absent: the preset's, and whether changed."""
    flange_height: LimitSettings | None = None
    """Sh."""
    flange_thickness_10: LimitSettings | None = None
    """Sd, 10 mm above the tread."""
    flange_thickness_12: LimitSettings | None = None
    """The same 12 mm above."""
    flange_gradient_qr: LimitSettings | None = None
    """qR."""
    tread_wear: LimitSettings | None = None
    """Sh less the reference's."""
    tread_wear_at_70: LimitSettings | None = None
    """Reference less measured height at the tape circle."""
    tread_wear_max: LimitSettings | None = None
    """The greatest such difference."""
    hollow_depth: LimitSettings | None = None
    """Depth of the tread's hollow."""
    diameter: LimitSettings | None = None
    """At the tape circle; where the sensors' sheets tell it."""
    back_to_back: RangeSettings | None = None
    """Between the flange backs of an axle. Those of a preset are for 1435 mm gauge and wheels over
    840 mm in diameter. Wear does not change it: no end is the worn one."""

    @model_validator(mode="before")
    @classmethod
    def _quantities_are_known(cls, given: object) -> object:
        names = given if isinstance(given, dict) else {}
        unknown = [name for name in names if name not in cls.model_fields]
        if unknown:
            quantities = ", ".join(name for name in cls.model_fields if name not in cls._NAMES)
            raise ValueError(f"no quantity {unknown[0]!r}; allowed: {quantities}")
        return given

    @property
    def given(self) -> dict[str, LimitSettings]:
        """The limits of quantities of a wheel that replace those of the preset."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: limit for name, limit in found.items() if isinstance(limit, LimitSettings)}
