"""A picture of a wheel that rolls through the sheet."""

from dataclasses import dataclass, field

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.rays import ray_map
from station.scenes.revolution import Revolution
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.steel import dirt
from station.scenes.texture import speckle
from station.scenes.wheel_light import body_light, stripe_light
from station.scenes.wheel_truth import WheelTruth

# Steel returns a half of what matt white does, and its flange meets the light at 80 degrees:
# the laser is set brighter for wheels than for targets.
_LASER_FOR_STEEL = 2.6
_MARGIN_PX = 24


@dataclass(frozen=True, slots=True, eq=False)
class WheelScene(Scene):
    """A wheel before the sensor; the truth is in its own fields.

    Attributes
    ----------
    sensor
        The camera and the sheet, exact.
    rig_from_camera
        Where the sensor stands (`trackside_mounting`).
    wheel
        The wheel's shape.
    axle_offset_mm
        Where the axle is on its way along the rail (rig x); at 0 the trackside sheet cuts a wheel
        of nominal radius radially.
    lateral_shift_mm
        How far the wheel has moved towards the field side (rig y).
    light
        The light.
    laser_on
        Whether the laser shines. A scene with the laser off is otherwise the same.
    seed
        What stands still and is left to chance: dirt, glare, surroundings, speckle.
    physics
        Roughness, lens and sensor chip.

    Raises
    ------
    ValueError
        If a place is not finite.
    """

    sensor: LaserSensor
    rig_from_camera: RigidTransform
    wheel: WheelTruth
    axle_offset_mm: float = 0.0
    lateral_shift_mm: float = 0.0
    light: Light = Light.GOOD
    laser_on: bool = True
    seed: int = 0
    physics: Physics = field(default_factory=Physics)

    def __post_init__(self) -> None:
        if not np.isfinite([self.axle_offset_mm, self.lateral_shift_mm]).all():
            raise ValueError(
                "axle_offset_mm and lateral_shift_mm must be finite, got "
                f"{self.axle_offset_mm} and {self.lateral_shift_mm}"
            )

    @property
    def rig_from_axle(self) -> RigidTransform:
        """Pose of the axle: its tread stands on the rail, y along it, origin at the tape circle."""
        place = [self.axle_offset_mm, self.lateral_shift_mm, self.wheel.radius_mm]
        return RigidTransform(np.eye(3), np.array(place))

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        body = Revolution(
            self.wheel.profile,
            self.wheel.radius_mm,
            self.rig_from_camera.inverse() @ self.rig_from_axle,
        )
        cover, light = body_light(body, self.sensor.camera, self.recipe, by_chance)
        frame *= 1.0 - cover
        frame += light
        if self.laser_on:
            self._add_stripes(frame, body, by_chance)

    def _add_stripes(self, frame: Counts, body: Revolution, by_chance: np.random.Generator) -> None:
        recipe = self.recipe
        sheet = LaserSheet.of_sensor(self.sensor, by_chance, unevenness=recipe.stripe_unevenness)
        stains = dirt(by_chance, len(body.profile.points_mm), 0.05, self.physics.grain)
        self._add_stripe(frame, body, sheet, stains, by_chance)
        if recipe.false_stripe > 0.0:
            false = sheet.reflected_through(
                _beside(body, sheet, by_chance), by_chance, power=0.5 * recipe.false_stripe
            )
            self._add_stripe(frame, body, false, stains, by_chance)

    def _add_stripe(
        self,
        frame: Counts,
        body: Revolution,
        sheet: LaserSheet,
        stains: FloatArray,
        by_chance: np.random.Generator,
    ) -> None:
        """Add the light of one sheet on the wheel to the picture."""
        camera = self.sensor.camera
        middle = body.section(sheet.plane, sheet.source_in_cam_mm, np.zeros(1)).points_in_cam_mm
        middle = middle[:, 0]
        middle = middle[middle[:, 2] > 0.0]
        if len(middle) == 0:
            return
        window = Window.around(camera.project(middle), camera, margin_px=_MARGIN_PX)
        if window.empty:
            return
        light = stripe_light(body, sheet, camera, window, stains)
        light *= np.float32(self.recipe.stripe * _LASER_FOR_STEEL)
        grains = speckle(by_chance, light.shape, self.physics.speckle)
        depth = _sheet_depth_mm(sheet, ray_map(camera, window))
        frame[window.slices] += self.physics.lens.blur(light, depth) * grains


def _sheet_depth_mm(sheet: LaserSheet, rays: Counts) -> Counts:
    a, b, c = sheet.plane.normal_in_cam.astype(np.float32)
    return np.asarray(-np.float32(sheet.plane.offset_mm) / (a * rays[0] + b * rays[1] + c))


def _beside(body: Revolution, sheet: LaserSheet, rng: np.random.Generator) -> FloatArray:
    """Return two points of the wheel, shape (2, 3), 10 to 30 mm beside the sheet."""
    shift_mm = rng.choice([-1.0, 1.0]) * rng.uniform(10.0, 30.0, 2)
    y = body.profile.points_mm[:, 0]
    strip = body.section(sheet.plane, sheet.source_in_cam_mm, shift_mm)
    tread = [int(np.argmin(np.abs(y[strip.place] - place))) for place in (-20.0, 45.0)]
    return strip.points_in_cam_mm[tread, [0, 1]]
