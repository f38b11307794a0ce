"""A rig calibrated from rendered showings of a rigid target, as somebody at the track would."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import LaserSensor, Rig, RigShowing, Target, calibrate, calibrate_rig
from station.bench.lights import TARGET, observe_scenes
from station.scenes import Light, RigidTarget, WheelRig, rig_showings, target_scenes

ANCHOR = "inner"
BOARD_SIGMA_MM = 0.02
"""How far each dot of the boards is printed off its place."""
SHOWINGS = 12
POSES = 20
"""Pictures that each sensor is calibrated from before, of a board without errors."""


@dataclass(frozen=True, slots=True, eq=False)
class BuiltRig:
    """A rig as it stands, and as a calibration has found it.

    Attributes
    ----------
    truth
        Where all truly is.
    showings, sensors, boards
        What the rig was calibrated from.
    found
        The answer, with the anchor where the survey says it is.
    """

    truth: WheelRig
    showings: tuple[RigShowing, ...]
    sensors: dict[str, LaserSensor]
    boards: dict[str, Target]
    found: Rig

    @classmethod
    def from_pictures(cls, lights: Sequence[Light], seed: int) -> "BuiltRig":
        """Build a rig by chance, show it its targets in some lights in turn, and calibrate it.

        Raises
        ------
        CalibError
            If the pictures do not suffice.
        """
        rng = np.random.default_rng([seed, len(lights)])
        truth = WheelRig.trackside("left").as_built(rng)
        sensors = {
            each.name: _calibrated(rng, each.sensor, lights, each.name) for each in truth.sensors
        }
        body = RigidTarget.board_each(rng, truth.sensors, TARGET, printing_sigma_mm=BOARD_SIGMA_MM)
        held = rig_showings(rng, truth.sensors, body, in_turn(lights, SHOWINGS))
        tasks = [
            (scene, number, f"{number:02d}-{name}")
            for number, showing in enumerate(held)
            for name, scene in showing.scenes.items()
        ]
        views = iter(observe_scenes(tasks))
        showings = []
        for number, showing in enumerate(held):
            seen = {name: next(views) for name in showing.scenes}
            views_of = {name: (name, view) for name, view in seen.items() if view is not None}
            showings.append(RigShowing(f"{number:02d}", views_of))
        boards = dict.fromkeys(truth.exact.names, TARGET)
        found = calibrate_rig(
            showings, sensors, boards, anchor=ANCHOR, sigma_board_mm=BOARD_SIGMA_MM
        )
        surveyed = found.rig.moved(truth.exact[ANCHOR].rig_from_camera)
        return cls(truth, tuple(showings), sensors, boards, surveyed)


def in_turn(lights: Sequence[Light], count: int) -> list[Light]:
    """Return so many lights, one after another and again."""
    return [lights[number % len(lights)] for number in range(count)]


def _calibrated(
    rng: np.random.Generator, truth: LaserSensor, lights: Sequence[Light], name: str
) -> LaserSensor:
    scenes = target_scenes(rng, truth, TARGET, in_turn(lights, POSES))
    tasks = [(scene, number, f"{name}-{number:02d}") for number, scene in enumerate(scenes)]
    views = [view for view in observe_scenes(tasks) if view is not None]
    camera = truth.camera
    return calibrate(views, TARGET, width=camera.width, height=camera.height).sensor
