"""What lies between a scene and its picture: roughness, lens, sensor chip."""

from dataclasses import dataclass, field
from typing import Self

from station.scenes.detector import Detector
from station.scenes.optics import Lens


@dataclass(frozen=True, slots=True)
class Physics:
    """How things and camera are made; the defaults are those of a real station.

    Attributes
    ----------
    grain
        Standard deviation over mean of the light that a surface returns from place to place.
    speckle
        Contrast of the laser's speckle, as the pixels see it.
    lens
        Blur, flare and vignetting.
    detector
        Noise and saturation.
    """

    grain: float = 0.12
    speckle: float = 0.09
    lens: Lens = field(default_factory=Lens)
    detector: Detector = field(default_factory=Detector)

    def __post_init__(self) -> None:
        if not (0.0 <= self.grain < 1.0 and 0.0 <= self.speckle < 1.0):
            raise ValueError(
                f"grain and speckle must be from 0 to below 1, got {self.grain}, {self.speckle}"
            )

    @classmethod
    def smooth(cls) -> Self:
        """Make perfectly even surfaces without speckle, for what only geometry may decide."""
        return cls(grain=0.0, speckle=0.0)
