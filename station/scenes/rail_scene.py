"""A picture of a rail in the laser's sheet, and no wheel."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from calib import LaserSensor, RigidTransform
from station.scenes.light import Light
from station.scenes.patch import Counts
from station.scenes.physics import Physics
from station.scenes.revolution import Revolution
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.steel import dirt
from station.scenes.stripe_on_body import add_stripe
from station.scenes.wheel_light import body_light
from station.scenes.wheel_truth import WheelProfile

_STRAIGHT_MM = 1e5
"""A rail is a wheel of 100 m: over the 0.4 m in view it rises by 0.2 mm."""
_STEP_MM = 0.05
_HALF_HEAD_MM, _SIDE_MM = 36.0, 38.0
_CROWN_MM, _CORNER_MM = 300.0, 13.0


@dataclass(frozen=True, slots=True, eq=False)
class RailScene(Scene):
    """The head of a rail where a wheel would stand, as a track machine carries it past.

    Attributes
    ----------
    sensor
        The camera and the sheet, exact.
    rig_from_camera
        Where the sensor stands.
    light, seed, physics
        As of a `WheelScene`.
    """

    sensor: LaserSensor
    rig_from_camera: RigidTransform
    light: Light = Light.GOOD
    seed: int = 0
    physics: Physics = field(default_factory=Physics)

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        camera, outline = self.sensor.camera, rail_head()
        body = Revolution(outline, _STRAIGHT_MM, self._cam_from_axle())
        cover, light = body_light(body, camera, self.recipe, by_chance)
        frame *= 1.0 - cover
        frame += light
        unevenness = self.recipe.stripe_unevenness
        add_stripe(
            frame,
            body,
            LaserSheet.of_sensor(self.sensor, by_chance, unevenness=unevenness),
            dirt(by_chance, len(outline.points_mm), _STEP_MM, self.physics.grain),
            by_chance,
            camera=camera,
            level=self.recipe.stripe,
            physics=self.physics,
        )

    def _cam_from_axle(self) -> RigidTransform:
        """Put the head's crown on the camera's axis, square to the sheet."""
        sensor = self.sensor
        aim = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))[0]
        outward = -aim - (-aim @ sensor.plane.normal_in_cam) * sensor.plane.normal_in_cam
        outward /= np.linalg.norm(outward)
        along = sensor.plane.normal_in_cam
        axes = np.column_stack([along, np.cross(outward, along), outward])
        return RigidTransform(axes, aim - _STRAIGHT_MM * outward)


@lru_cache(maxsize=1)
def rail_head() -> WheelProfile:
    """Return the head of a rail: a crown of 300 mm, corners of 13 mm, upright sides."""
    flat = _HALF_HEAD_MM - _CORNER_MM
    drop = _CROWN_MM - np.sqrt(_CROWN_MM**2 - flat**2)
    angle = np.linspace(0.0, np.pi / 2.0, 400)
    corner = np.column_stack([
        flat + _CORNER_MM * np.sin(angle),
        -drop - _CORNER_MM * (1.0 - np.cos(angle)),
    ])
    y = np.arange(0.0, flat, _STEP_MM)
    crown = np.column_stack([y, np.sqrt(_CROWN_MM**2 - y**2) - _CROWN_MM])
    z = np.arange(corner[-1, 1] - _STEP_MM, -_SIDE_MM, -_STEP_MM)
    side = np.column_stack([np.full(len(z), _HALF_HEAD_MM), z])
    half = np.concatenate([crown, corner, side])
    return WheelProfile(np.concatenate([half[:0:-1] * [-1.0, 1.0], half]))
