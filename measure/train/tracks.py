"""What the sensors of a pass saw, on one clock."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np


class Side(StrEnum):
    """A side of the train, in the direction it runs."""

    LEFT = "left"
    RIGHT = "right"


@dataclass(frozen=True, slots=True)
class SeenWheel:
    """One group of frames that a sensor's recording was sorted into.

    Attributes
    ----------
    key
        What the caller knows it by.
    time_s
        When, by a clock that all sensors of the pass share.
    first, last
        Numbers of its first and last frame; triggers are numbered from 1.
    """

    key: int
    time_s: float
    first: int
    last: int

    def __post_init__(self) -> None:
        if not (np.isfinite(self.time_s) and self.first <= self.last):
            raise ValueError(f"a seen wheel has a time and frames in order, got {self!r}")


@dataclass(frozen=True, slots=True)
class Track:
    """All that one sensor saw of a pass.

    Attributes
    ----------
    sensor, side
        Which sensor, and the side of the train it looks at.
    wheels
        In any order.
    triggers
        Triggers the controller gave it; None where nobody counted.
    silent
        Why it saw no wheel at all; None where it could have.
    """

    sensor: str
    side: Side
    wheels: tuple[SeenWheel, ...] = ()
    triggers: int | None = None
    silent: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "wheels", tuple(sorted(self.wheels, key=lambda wheel: wheel.time_s))
        )


@dataclass(frozen=True, slots=True)
class Sighting:
    """One axle as one sensor saw it, in one group of frames or several.

    Attributes
    ----------
    track
        Place of the sensor's track among those of the pass.
    wheels
        The groups, in the order of time.
    axle
        Which axle of the train it is, where the numbers of triggers tell it.
    """

    track: int
    wheels: tuple[SeenWheel, ...]
    axle: int | None = None

    @property
    def time_s(self) -> float:
        """When, in the middle of its groups."""
        return float(np.mean([wheel.time_s for wheel in self.wheels]))


@dataclass(frozen=True, slots=True)
class Crossing:
    """One axle as all sensors saw it."""

    sightings: tuple[Sighting, ...]

    @property
    def time_s(self) -> float:
        """When the first of the sensors saw it, by their order."""
        return self.sightings[0].time_s
