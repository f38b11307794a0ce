"""What is true in the demo: two sensors, their target poses, a train of eight wheels."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib import LaserSensor, LightPlane, Picture, RigidTransform, Target
from station.scenes import (
    Light,
    TargetScene,
    WheelScene,
    WheelTruth,
    paper_sensor,
    target_scenes,
    trackside_mounting,
)

TARGET = Target.parse("dots:7x8:12:d=6")
REFERENCE = "S1002"
POSES = 20
AXLES = 4
OFFSETS_MM = (-24.0, -2.0, 20.0)
"""Where the wheel sensor on the rail triggers, as the axle's place along the rail."""

_SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")
_ADDRESSES = {"left": "127.0.53.1", "right": "127.0.53.2"}


@dataclass(frozen=True, slots=True, eq=False)
class SensorTruth:
    """One sensor of the demo and everything it will see, in order."""

    id: str
    side: Literal["left", "right"]
    address: str
    sensor: LaserSensor
    rig_from_camera: RigidTransform
    poses: tuple[TargetScene, ...]
    wheels: tuple[WheelTruth, ...]
    passes: tuple[WheelScene, ...]
    noise_seed: int

    @property
    def scenes(self) -> tuple[TargetScene | WheelScene, ...]:
        """What each exposure shows, from the first calibration picture to the last wheel."""
        return (*self.poses, *self.passes)

    def render(self, index: int) -> Picture:
        """Take the picture of one exposure."""
        return self.scenes[index].render(np.random.default_rng((self.noise_seed, index)))


@dataclass(frozen=True, slots=True)
class Scenario:
    """The whole truth of one demo."""

    seed: int
    sensors: tuple[SensorTruth, ...]

    @classmethod
    def draw(cls, seed: int) -> "Scenario":
        """Draw the demo of a seed."""
        rng = np.random.default_rng(seed)
        return cls(seed, tuple(_draw_sensor(rng, side) for side in _SIDES))


def _draw_sensor(rng: np.random.Generator, side: Literal["left", "right"]) -> SensorTruth:
    sensor = _as_built(rng, paper_sensor())
    mounting = trackside_mounting(side)
    wheels = tuple(_draw_wheel(rng) for _ in range(AXLES))
    lights = [light for _, light in zip(range(POSES), _mixed_lights(), strict=False)]
    return SensorTruth(
        id=side,
        side=side,
        address=_ADDRESSES[side],
        sensor=sensor,
        rig_from_camera=mounting,
        poses=target_scenes(rng, sensor, TARGET, lights),
        wheels=wheels,
        passes=tuple(scene for wheel in wheels for scene in _roll_by(rng, sensor, mounting, wheel)),
        noise_seed=int(rng.integers(2**32)),
    )


def _as_built(rng: np.random.Generator, design: LaserSensor) -> LaserSensor:
    """No two sensors leave the bench alike: turn the sheet by some tenths of a degree."""
    turn = RigidTransform.from_rotation_vector(rng.normal(0.0, 4e-3, 3), np.zeros(3))
    normal = turn.apply(design.plane.normal_in_cam[None])[0]
    offset_mm = design.plane.offset_mm + float(rng.normal(0.0, 0.5))
    return LaserSensor.exact(design.camera, LightPlane.from_coefficients([*normal, offset_mm]))


def _mixed_lights() -> list[Light]:
    """Every light in turn, the good one no more often than a bad one."""
    return [light for _ in range(POSES) for light in Light]


def _draw_wheel(rng: np.random.Generator) -> WheelTruth:
    return WheelTruth(
        reference=REFERENCE,
        tread_wear_mm=float(rng.uniform(0.0, 6.0)),
        flange_wear_mm=float(rng.uniform(0.0, 4.0)),
        radius_mm=420.0 + float(rng.normal(0.0, 3.0)),
    )


def _roll_by(
    rng: np.random.Generator, sensor: LaserSensor, mounting: RigidTransform, wheel: WheelTruth
) -> list[WheelScene]:
    lateral_mm = float(rng.normal(0.0, 2.0))
    seed = int(rng.integers(2**32))
    return [
        WheelScene(
            sensor,
            mounting,
            wheel,
            axle_offset_mm=offset_mm + float(rng.normal(0.0, 1.0)),
            lateral_shift_mm=lateral_mm,
            light=Light.GOOD,
            seed=seed,
        )
        for offset_mm in OFFSETS_MM
    ]
