"""The sensors of one wheel as they were built, and what they see of it together."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from calib import (
    RIG_PARAMETERS,
    LaserSensor,
    LightPlane,
    Rig,
    RigidTransform,
    RigSensor,
    frozen,
    moved_by,
)
from station.scenes.installation import Place, Side, paper_sensor, trackside_mounting
from station.scenes.light import RECIPES, Light
from station.scenes.physics import Physics
from station.scenes.sheet import LaserSheet
from station.scenes.wheel_faults import WheelFaults
from station.scenes.wheel_scene import WheelScene
from station.scenes.wheel_truth import WheelTruth

_SHEET_TURN_RAD, _SHEET_SHIFT_MM = 4e-3, 0.5
_POSE_TURN_RAD, _POSE_SHIFT_MM = 5e-3, 1.5


def sensor_as_built(rng: np.random.Generator, design: LaserSensor) -> LaserSensor:
    """Turn and move the sheet of a sensor a little: no two leave the bench alike."""
    turn = RigidTransform.from_rotation_vector(rng.normal(0.0, _SHEET_TURN_RAD, 3), np.zeros(3))
    normal = turn.apply(design.plane.normal_in_cam[None])[0]
    offset_mm = design.plane.offset_mm + float(rng.normal(0.0, _SHEET_SHIFT_MM))
    return LaserSensor.exact(design.camera, LightPlane.from_coefficients([*normal, offset_mm]))


@dataclass(frozen=True, slots=True, eq=False)
class WheelRig:
    """The sensors of one wheel, exactly known, in the rig frame.

    Attributes
    ----------
    sensors
        Each with its name, its camera and sheet, and where it stands.
    """

    sensors: tuple[RigSensor, ...]

    @classmethod
    def trackside(
        cls,
        side: Side,
        places: tuple[Place, ...] = ("inner", "outer"),
        *,
        prefix: str = "",
        below_horizon_rad: Mapping[Place, float] | None = None,
    ) -> Self:
        """Make the rig as it was designed, its sensors named by a prefix and their places.

        Parameters
        ----------
        side, places
            As `trackside_mounting` takes them.
        prefix
            What the names begin with.
        below_horizon_rad
            Other angles for some of the places.
        """
        angles = dict(below_horizon_rad or {})
        poses = [
            trackside_mounting(side, place, below_horizon_rad=angles.get(place)) for place in places
        ]
        return cls(
            tuple(
                RigSensor(f"{prefix}{place}", paper_sensor(), pose)
                for place, pose in zip(places, poses, strict=True)
            )
        )

    def as_built(self, rng: np.random.Generator) -> "WheelRig":
        """Return the rig as somebody set it up: sheets and poses are not quite those designed."""
        built = []
        for each in self.sensors:
            step = np.concatenate([
                rng.normal(0.0, _POSE_TURN_RAD, 3),
                rng.normal(0.0, _POSE_SHIFT_MM, 3),
            ])
            pose = moved_by(each.rig_from_camera, step)
            built.append(RigSensor(each.name, sensor_as_built(rng, each.sensor), pose))
        return WheelRig(tuple(built))

    @property
    def exact(self) -> Rig:
        """The rig as a calibration without any error would find it."""
        size = len(RIG_PARAMETERS) * len(self.sensors)
        return Rig(self.sensors, np.zeros((size, size)))

    def shot(
        self,
        wheel: WheelTruth,
        *,
        axle_offset_mm: float = 0.0,
        lateral_shift_mm: float = 0.0,
        light: Light = Light.GOOD,
        seed: int = 0,
        vibration_mm: Mapping[str, ArrayLike] | None = None,
        others_share: float = 0.0,
        physics: Physics | None = None,
        faults: WheelFaults | None = None,
    ) -> dict[str, WheelScene]:
        """Return what each sensor sees of a wheel when all take a picture, by name.

        Parameters
        ----------
        wheel, axle_offset_mm, lateral_shift_mm, light, physics, faults
            As in `WheelScene`, the same for all.
        seed
            What is left to chance.
        vibration_mm
            How far sensors have moved, each shape (3,), rig frame; those not named stand still.
        others_share
            Brightness of the other sensors' lasers in a picture over its own. Lasers are strobed
            in turn, hence 0; a strobe out of step lets some of it in.

        Raises
        ------
        ValueError
            If a place is not finite, or a sensor is named that there is not.
        """
        moves = dict(vibration_mm or {})
        names = [each.name for each in self.sensors]
        if not set(moves) <= set(names):
            raise ValueError(f"vibration of {sorted(moves)}; the sensors are {names}")
        poses = [_moved(each.rig_from_camera, moves.get(each.name)) for each in self.sensors]
        return {
            name: WheelScene(
                self.sensors[place].sensor,
                poses[place],
                wheel,
                axle_offset_mm=axle_offset_mm,
                lateral_shift_mm=lateral_shift_mm,
                light=light,
                # Each camera has its own surroundings and speckle; the dirt is the wheel's.
                seed=int(np.random.SeedSequence([seed, place]).generate_state(1)[0]),
                soil_seed=seed,
                physics=physics or Physics(),
                faults=faults or WheelFaults(),
                other_sheets=tuple(
                    self._sheet(other, light, seed, others_share).seen_from(
                        poses[place].inverse() @ poses[other]
                    )
                    for other in range(len(poses))
                    if other != place and others_share > 0.0
                ),
            )
            for place, name in enumerate(names)
        }

    def _sheet(self, place: int, light: Light, seed: int, power: float) -> LaserSheet:
        """Return the laser of a sensor in its own camera's frame, as bright as asked for."""
        chance = np.random.default_rng([seed, place])
        uneven = RECIPES[light].stripe_unevenness
        sheet = LaserSheet.of_sensor(self.sensors[place].sensor, chance, unevenness=uneven)
        return replace(sheet, power=power)


def _moved(rig_from_camera: RigidTransform, shift_mm: ArrayLike | None) -> RigidTransform:
    if shift_mm is None:
        return rig_from_camera
    shift = frozen(shift_mm, (3,), "vibration_mm")
    return moved_by(rig_from_camera, np.concatenate([np.zeros(3), shift]))
