"""Where a wheel stood beside the rig when a shot of it was taken."""

from dataclasses import dataclass

from calib import FloatArray, frozen
from measure.gauging.uncertainty import Budget


@dataclass(frozen=True, slots=True, eq=False)
class TreadPoint:
    """Where the sheet of a sensor meets the tape circle.

    Attributes
    ----------
    sensor
        Whose sheet it is.
    place_mm
        Shape (2,), (x, z) in the rig frame.
    single_mm
        Standard deviation along the radius, independent from shot to shot.
    shared_mm
        Shape (2, Q): motion of the place for one sigma of each cause that all shots share.
    """

    sensor: str
    place_mm: FloatArray
    single_mm: float
    shared_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "place_mm", frozen(self.place_mm, (2,), "place_mm"))


@dataclass(frozen=True, slots=True, eq=False)
class WheelPlace:
    """Where a wheel stood.

    Attributes
    ----------
    time_ns
        When; None of pictures that have no time.
    back_mm
        Rig y of the flange back; None where it was not seen.
    back
        What is not known of it; None with it.
    treads
        Where the sheets met the tape circle, of each sensor that saw it. Their shared causes and
        those of the flange back are the same in all places of one wheel, in the same columns.
    back_at_mm
        Shape (2,), rig (x, z) of where the flange back was seen; None where that is not said.
    """

    time_ns: int | None
    back_mm: float | None
    back: Budget | None
    treads: tuple[TreadPoint, ...]
    back_at_mm: FloatArray | None = None
