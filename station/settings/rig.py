"""The settings of a rig: sensors that look at the same wheel from several sides."""

from typing import Literal, Self

from pydantic import Field, model_validator

from station.settings.section import Section
from station.settings.sensor import SensorId

MAX_SKEW_US = 5000.0
"""The cameras of a rig share a trigger line, but each time is mapped to UTC by itself: 0.5 ms off
where a camera keeps UTC, 1 ms or so where its clock is judged by its frames; two of them, and
lasers that flash in turn, make 3 ms. At 53 frames a second the next frame comes after 19 ms: half
of that is the most that tells two triggers apart."""


class RigSettings(Section):
    """Sensors of one side whose pictures of a wheel are measured together.

    A sensor that is in no rig is measured by itself: the simplest rig.
    """

    id: SensorId
    """Name of the rig, as of a sensor; readings bear it in place of a sensor's."""
    sensors: tuple[SensorId, ...] = Field(min_length=2)
    """Its sensors, two or more."""
    side: Literal["left", "right"] | None = None
    """The side of the train whose wheels it sees; absent: that of its sensors."""
    anchor: SensorId | None = None
    """The sensor whose mounting places the rig; absent: the first that has one."""
    max_skew_us: float = Field(default=MAX_SKEW_US, gt=0.0, le=1e6)
    """Frames of its sensors that are farther apart are not of one trigger, us."""
    sigma_vibration_mm: float | None = Field(default=None, gt=0.0)
    """How far its sensors move against each other between their exposures, one sigma, mm; this
    and the next, where absent: as `measure.Survey` takes them."""
    sigma_vibration_rad: float | None = Field(default=None, gt=0.0)
    """How far they turn against each other in the section, rad."""

    @model_validator(mode="after")
    def _names_are_of_its_own(self) -> Self:
        twice = {name for name in self.sensors if self.sensors.count(name) > 1}
        if twice:
            raise ValueError(f"rig {self.id} names sensor {min(twice)} twice; give each once")
        if self.anchor is not None and self.anchor not in self.sensors:
            raise ValueError(
                f"rig {self.id} has the anchor {self.anchor}; "
                f"allowed: one of its sensors, {', '.join(self.sensors)}"
            )
        return self
