"""The pictures of the demo station: each rendered once, and shown as often as it is wanted."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from demo_station_truth import (
    FIRST_LIGHTS,
    HEIGHT_PX,
    INNER,
    LEVELS,
    NIGHT_POSES,
    OUTER,
    RIGHT,
    SENSORS,
    WIDTH_PX,
    Truth,
)

from calib import Picture
from station.scenes import Light

_DARK_LEVEL, _DARK_SIGMA = 8.0, 2.0


@dataclass(frozen=True)
class Pictures:
    """What the cameras of the demo station have seen, by what was before them."""

    targets: dict[str, list[Picture]]
    """Of each sensor's first calibration session."""
    nights: list[list[Picture]]
    """Of the right sensor's sessions after that; in the last two its sheet has turned."""
    wheels: dict[str, list[list[Picture]]]
    """Of each sensor, by the stage of wear and the trigger."""
    dark: Picture
    """What any of them sees where there is nothing."""

    @classmethod
    def rendered(cls, truth: Truth) -> "Pictures":
        """Render them all."""
        rng = np.random.default_rng([truth.seed, 99])
        showings = truth.showings()
        targets = {
            name: [showing[name].render(rng) for showing in showings] for name in (INNER, OUTER)
        }
        targets[RIGHT] = [scene.render(rng) for scene in truth.poses(FIRST_LIGHTS, 0)]
        in_good_light = [Light.GOOD] * NIGHT_POSES
        nights = [
            [scene.render(rng) for scene in truth.poses(in_good_light, draw, drifting=draw > 2)]
            for draw in range(1, 5)
        ]
        shots = [truth.shots(level) for level in range(LEVELS)]
        wheels = {
            name: [[shot[name].render(rng) for shot in of_level] for of_level in shots]
            for name in SENSORS
        }
        noise = rng.normal(_DARK_LEVEL, _DARK_SIGMA, (HEIGHT_PX, WIDTH_PX))
        return cls(targets, nights, wheels, noise.clip(0, 255).astype(np.uint8))

    @classmethod
    def of_films(cls, folder: Path) -> "Pictures":
        """Return what `keep` put into a folder: the targets."""
        targets = {name: list(np.load(folder / f"target-{name}.npy")) for name in SENSORS}
        return cls(targets, [], {}, np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8))

    def keep(self, folder: Path) -> None:
        """Put into a folder what the simulated cameras show: a train, and a target."""
        folder.mkdir(parents=True)
        for sensor, of_levels in self.wheels.items():
            # As they come by: stage after stage.
            train = [of_level[0] for of_level in of_levels]
            np.save(folder / f"train-{sensor}.npy", np.stack(train))
            np.save(folder / f"target-{sensor}.npy", np.stack(self.targets[sensor]))
