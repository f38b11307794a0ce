"""What a wheel in service does to the laser's stripe besides being in a bad light."""

from dataclasses import dataclass, field

import numpy as np

from station.scenes.coat import Soiling


@dataclass(frozen=True, slots=True)
class WheelFaults:
    """What is wrong with a picture of a wheel; by default nothing.

    Attributes
    ----------
    mirror_share
        Share of the light that the best polished steel of flange and tread mirrors: the camera
        sees the stripe in it again. 0.1 to 0.3 on a wheel in daily service.
    sun_stripe
        Brightness of a stripe of sunlight beside the laser's, over that of the laser.
    soiling
        Dirt, rust, grease and shine.

    Raises
    ------
    ValueError
        If a share or a brightness is out of range.
    """

    mirror_share: float = 0.0
    sun_stripe: float = 0.0
    soiling: Soiling = field(default_factory=Soiling)

    def __post_init__(self) -> None:
        if not 0.0 <= self.mirror_share <= 1.0:
            raise ValueError(f"mirror_share must be from 0 to 1, got {self.mirror_share}")
        if not 0.0 <= self.sun_stripe < np.inf:
            raise ValueError(f"sun_stripe must not be negative, got {self.sun_stripe}")
