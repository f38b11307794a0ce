"""What is true at the demo station: its sensors, what is shown to them, the wheels of its trains.

Cameras of a quarter of the paper's pixels: pictures that cost a quarter to render, write and
measure, and readings that are as real.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib import CameraModel, LaserSensor, LightPlane, RigidTransform, RigSensor, Target
from station.scenes import (
    Light,
    RigidTarget,
    TargetScene,
    WheelRig,
    WheelScene,
    WheelTruth,
    paper_sensor,
    rig_showings,
    target_scenes,
    trackside_mounting,
)

INNER, OUTER, RIGHT = "left-inner", "left-outer", "right"
SENSORS = (INNER, OUTER, RIGHT)
RIG = "left"
WIDTH_PX, HEIGHT_PX = 1024, 544
SHOWINGS, NIGHT_POSES = 10, 6
"""Of the rig's target, and of the right sensor's in a night."""
BAD_LIGHTS = (Light.REFLECTION, Light.OVER_EXPOSED, Light.CROSSING, Light.STRAY)
FIRST_LIGHTS = (Light.GOOD,) * 6 + BAD_LIGHTS
"""In which the right sensor's target was shown first: bad ones leave doubtful points behind."""
BOARDS = {
    INNER: Target.parse("dots:6x7:26:d=9"),
    OUTER: Target.parse("dots:5x8:24:d=9"),
    RIGHT: Target.parse("dots:6x7:24:d=9"),
}
BOARD_SIGMA_MM = 0.002
OFFSETS_MM = (-9.0, 8.0)
"""Where the wheel sensor on the rail triggers, as the axle's place along the rail."""
SEEN_TWICE = range(2, 6)
"""Stages of wear of which there is a second shot: pictures are what making the station costs."""
TRACK_MM = 1500.0
"""From tape circle to tape circle: 1360 mm between the flange backs."""
LEVELS = 9
"""Stages of wear; from one pass to the next a wheel goes on by one."""
DRIFT_RAD = 6e-4


def wheel_at(level: int, side: str) -> WheelTruth:
    """Return a wheel of the train at a stage of its wear."""
    tread_mm = 0.4 + 0.72 * level
    share = 1.0 if side == "left" else 0.9
    return WheelTruth(
        "S1002",
        tread_wear_mm=share * tread_mm,
        flange_wear_mm=share * (0.2 + 0.35 * level),
        radius_mm=421.0 - share * tread_mm,
    )


def halved(sensor: LaserSensor) -> LaserSensor:
    """Return a sensor whose camera has half of the columns and rows."""
    parameters = sensor.camera.parameters.copy()
    parameters[:2] *= 0.5
    parameters[2:4] = (parameters[2:4] + 0.5) * 0.5 - 0.5
    camera = CameraModel.from_parameters(parameters, width=WIDTH_PX, height=HEIGHT_PX)
    return LaserSensor.exact(camera, sensor.plane)


def drifted(sensor: LaserSensor) -> LaserSensor:
    """Return a sensor whose sheet has turned a little about where it meets the camera's axis."""
    plane = sensor.plane
    turn = RigidTransform.from_rotation_vector((DRIFT_RAD, 0.0, 0.0), (0.0, 0.0, 0.0))
    normal = turn.apply(plane.normal_in_cam[None])[0]
    on_axis = plane.intersect(np.array([[0.0, 0.0, 1.0]]))[0]
    plane = LightPlane.from_coefficients([*normal, -float(normal @ on_axis)])
    return LaserSensor.exact(sensor.camera, plane)


@dataclass(frozen=True)
class Truth:
    """The whole truth of one demo station."""

    seed: int

    @cached_property
    def rig(self) -> WheelRig:
        """The two sensors on the left, as they were set up."""
        built = WheelRig.trackside("left", prefix="left-").as_built(self._rng(1))
        placed = [
            RigSensor(each.name, halved(each.sensor), each.rig_from_camera)
            for each in built.sensors
        ]
        return WheelRig(tuple(placed))

    @cached_property
    def right(self) -> RigSensor:
        """The one on the right, which sees its wheels by itself."""
        return RigSensor(RIGHT, halved(paper_sensor()), trackside_mounting("right"))

    def mounting(self, sensor: str) -> RigidTransform:
        """Return where a sensor stands, as the survey found it."""
        placed = {each.name: each for each in (*self.rig.sensors, self.right)}
        return placed[sensor].rig_from_camera

    def showings(self) -> list[dict[str, TargetScene]]:
        """Return what the left sensors see of their rigid target, showing by showing."""
        rng = self._rng(2)
        boards = (BOARDS[INNER], BOARDS[OUTER])
        body = RigidTarget.board_each(
            rng, self.rig.sensors, boards, printing_sigma_mm=BOARD_SIGMA_MM
        )
        shown = rig_showings(rng, self.rig.sensors, body, [Light.GOOD] * SHOWINGS)
        return [dict(each.scenes) for each in shown]

    def poses(
        self, lights: Sequence[Light], draw: int, *, drifting: bool = False
    ) -> list[TargetScene]:
        """Return what the right sensor sees of its target, in a light each time."""
        sensor = drifted(self.right.sensor) if drifting else self.right.sensor
        return list(target_scenes(self._rng(3, draw), sensor, BOARDS[RIGHT], lights))

    def shots(self, level: int) -> list[dict[str, WheelScene]]:
        """Return what each sensor sees of both wheels of an axle, trigger by trigger."""
        offsets = OFFSETS_MM if level in SEEN_TWICE else OFFSETS_MM[:1]
        return [self._shot(level, place, offset) for place, offset in enumerate(offsets)]

    def _shot(self, level: int, place: int, offset_mm: float) -> dict[str, WheelScene]:
        seed = int(np.random.SeedSequence([self.seed, level]).generate_state(1)[0])
        lateral_mm = float(self._rng(4, level).normal(0.0, 1.5))
        shot = self.rig.shot(
            wheel_at(level, "left"),
            axle_offset_mm=offset_mm,
            lateral_shift_mm=lateral_mm,
            seed=seed + place,
        )
        shot[RIGHT] = WheelScene(
            self.right.sensor,
            self.right.rig_from_camera,
            wheel_at(level, "right"),
            axle_offset_mm=offset_mm,
            # Rig y points to the field on both sides: what comes nearer on one goes on the other.
            lateral_shift_mm=-lateral_mm,
            seed=seed + 7 + place,
        )
        return shot

    def _rng(self, *what: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, *what])
