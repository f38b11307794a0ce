"""Pictures of wheels that pass the paper's sensor, for benches that time what is done with them."""

from collections.abc import Sequence

import numpy as np

from calib import Picture
from station.scenes import WheelScene, WheelTruth, paper_sensor, trackside_mounting


def rendered_wheels(
    wheels: int, offsets_mm: Sequence[float], *, wear_step_mm: float = 1.0
) -> list[Picture]:
    """Render wheels, each more worn than the one before, one picture at each of the offsets.

    Parameters
    ----------
    wheels
        How many; the first one is new.
    offsets_mm
        Where the axle is along the rail, as of a `WheelScene`.
    wear_step_mm
        How much more the tread of each is worn.
    """
    rng = np.random.default_rng(1)
    return [
        WheelScene(
            paper_sensor(),
            trackside_mounting("left"),
            WheelTruth(tread_wear_mm=wear_step_mm * wheel),
            axle_offset_mm=offset_mm,
            seed=wheel,
        ).render(rng)
        for wheel in range(wheels)
        for offset_mm in offsets_mm
    ]
