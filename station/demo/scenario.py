"""What is true in the demo: two rigs, showings of a target to them, a train of eight wheels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import LaserSensor, Picture, Rig, RigidTransform, RigSensor, Target
from measure import Side
from station.scenes import (
    Light,
    Place,
    RigidTarget,
    TargetScene,
    WheelRig,
    WheelScene,
    WheelTruth,
    rig_showings,
)

REFERENCE = "S1002"
SHOWINGS = 16
AXLES = 4
OFFSETS_MM = (-24.0, -2.0, 20.0)
"""Where the wheel sensor on the rail triggers, as the axle's place along the rail."""
BOARD_SIGMA_MM = 0.002
"""How far dots are from their places: a mask written on glass before the lamps."""

_PLACES: tuple[Place, ...] = ("inner", "outer")
_BOARDS = tuple(Target.parse(text) for text in ("dots:7x8:12:d=6", "dots:6x9:12:d=6"))
"""One a sensor, neither of which can be taken for the other."""
_VIBRATION_MM = 0.3
_ADDRESSES = {
    "left-inner": "127.0.53.1",
    "left-outer": "127.0.53.2",
    "right-inner": "127.0.53.3",
    "right-outer": "127.0.53.4",
}


@dataclass(frozen=True, slots=True, eq=False)
class SensorTruth:
    """One sensor of the demo and everything it will see, in order."""

    id: str
    address: str
    target: Target
    sensor: LaserSensor
    rig_from_camera: RigidTransform
    poses: tuple[TargetScene, ...]
    passes: tuple[WheelScene, ...]
    noise_seed: int

    @property
    def scenes(self) -> tuple[TargetScene | WheelScene, ...]:
        """What each exposure shows, from the first calibration picture to the last wheel."""
        return (*self.poses, *self.passes)

    def render(self, index: int) -> Picture:
        """Take the picture of one exposure."""
        return self.scenes[index].render(np.random.default_rng((self.noise_seed, index)))


@dataclass(frozen=True, slots=True, eq=False)
class RigTruth:
    """The sensors that look at the wheels of one side, and those wheels."""

    id: str
    side: Side
    sensors: tuple[SensorTruth, ...]
    wheels: tuple[WheelTruth, ...]

    @property
    def exact(self) -> Rig:
        """The rig as a calibration without any error would find it."""
        placed = [RigSensor(each.id, each.sensor, each.rig_from_camera) for each in self.sensors]
        return WheelRig(tuple(placed)).exact

    @property
    def anchor(self) -> SensorTruth:
        """The sensor whose place beside the track was surveyed."""
        return self.sensors[0]


@dataclass(frozen=True, slots=True)
class Scenario:
    """The whole truth of one demo."""

    seed: int
    rigs: tuple[RigTruth, ...]

    @classmethod
    def draw(cls, seed: int) -> "Scenario":
        """Draw the demo of a seed."""
        rng = np.random.default_rng(seed)
        return cls(seed, tuple(_draw_rig(rng, side) for side in Side))

    @property
    def sensors(self) -> tuple[SensorTruth, ...]:
        """The sensors of all rigs."""
        return tuple(sensor for rig in self.rigs for sensor in rig.sensors)


def _draw_rig(rng: np.random.Generator, side: Side) -> RigTruth:
    rig = WheelRig.trackside(side.value, _PLACES, prefix=f"{side.value}-").as_built(rng)
    body = RigidTarget.board_each(rng, rig.sensors, _BOARDS, printing_sigma_mm=BOARD_SIGMA_MM)
    showings = rig_showings(rng, rig.sensors, body, _mixed_lights())
    wheels = tuple(_draw_wheel(rng) for _ in range(AXLES))
    shots = [shot for wheel in wheels for shot in _roll_by(rng, rig, wheel)]
    sensors = tuple(
        SensorTruth(
            id=each.name,
            address=_ADDRESSES[each.name],
            target=board,
            sensor=each.sensor,
            rig_from_camera=each.rig_from_camera,
            poses=tuple(showing.scenes[each.name] for showing in showings),
            passes=tuple(shot[each.name] for shot in shots),
            noise_seed=int(rng.integers(2**32)),
        )
        for each, board in zip(rig.sensors, _BOARDS, strict=True)
    )
    return RigTruth(side.value, side, sensors, wheels)


def _mixed_lights() -> Sequence[Light]:
    """Every light in turn, the good one no more often than a bad one."""
    return [light for _ in range(SHOWINGS) for light in Light][:SHOWINGS]


def _draw_wheel(rng: np.random.Generator) -> WheelTruth:
    return WheelTruth(
        reference=REFERENCE,
        tread_wear_mm=float(rng.uniform(0.0, 6.0)),
        flange_wear_mm=float(rng.uniform(0.0, 4.0)),
        radius_mm=420.0 + float(rng.normal(0.0, 3.0)),
    )


def _roll_by(
    rng: np.random.Generator, rig: WheelRig, wheel: WheelTruth
) -> list[dict[str, WheelScene]]:
    """Return what each sensor sees at each trigger, while the track shakes them all."""
    lateral_mm = float(rng.normal(0.0, 2.0))
    seed = int(rng.integers(2**32))
    return [
        rig.shot(
            wheel,
            axle_offset_mm=offset_mm + float(rng.normal(0.0, 1.0)),
            lateral_shift_mm=lateral_mm,
            seed=seed,
            vibration_mm={each.name: rng.normal(0.0, _VIBRATION_MM, 3) for each in rig.sensors},
        )
        for offset_mm in OFFSETS_MM
    ]
