"""The `[controller]` of the settings file: after how much silence a pass ends by itself."""

from typing import Self

from pydantic import Field, model_validator

from station.settings.section import Section


class ControllerSettings(Section):
    """How long the station records for a controller, or a person, that is not heard of; inf: on.

    What was recorded until then is kept and measured as after a finish.
    """

    quiet_s: float = Field(default=300.0, gt=0.0)
    """A pass ends so long after the last frame of any sensor, or after it was armed, s: longer than
    a train may stand still before the sensors."""
    pass_longest_s: float = Field(default=1800.0, gt=0.0)
    """A pass ends so long after it was armed whatever is seen, s: longer than any train takes."""
    session_quiet_s: float = Field(default=3600.0, gt=0.0)
    """A calibration session ends so long after its last picture, or after it was opened, s."""

    @model_validator(mode="after")
    def _quiet_comes_first(self) -> Self:
        if self.quiet_s > self.pass_longest_s:
            raise ValueError(
                f"quiet_s {self.quiet_s:g} is more than pass_longest_s {self.pass_longest_s:g}, so "
                "no pass would ever be quiet for so long; give at most as much"
            )
        return self
