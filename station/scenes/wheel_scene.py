"""A picture of a wheel that rolls through the sheet."""

from dataclasses import dataclass, field

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform
from station.scenes.double_reflection import mirrored_stripe
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.revolution import Revolution
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.steel import dirt
from station.scenes.stripe_on_body import LASER_FOR_STEEL, add_stripe, depth_of_sheet
from station.scenes.sun_stripe import sun_through_slit
from station.scenes.wheel_faults import WheelFaults
from station.scenes.wheel_light import body_light
from station.scenes.wheel_truth import WheelProfile, WheelTruth


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
    faults
        What else is wrong with the picture.
    neighbours_mm
        Lateral places, from this wheel, of more wheels of the same shape on the same axle line.
    soil_seed
        What of the soiling is left to chance, where several cameras see one wheel: it is the
        wheel's. None: as `seed` has it.
    other_sheets
        Lasers of other sensors that shine as well.

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
    faults: WheelFaults = field(default_factory=WheelFaults)
    neighbours_mm: tuple[float, ...] = ()
    soil_seed: int | None = None
    other_sheets: tuple[LaserSheet, ...] = ()

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
        for beside_mm in (0.0, *self.neighbours_mm):
            self._add_wheel(frame, beside_mm, by_chance)

    def _add_wheel(self, frame: Counts, beside_mm: float, by_chance: np.random.Generator) -> None:
        place = RigidTransform(np.eye(3), np.array([0.0, beside_mm, 0.0])) @ self.rig_from_axle
        cam_from_axle = self.rig_from_camera.inverse() @ place
        outline = self.wheel.profile.points_mm
        soil_seed = self.seed if self.soil_seed is None else self.soil_seed
        coat = self.faults.soiling.coat(outline, np.random.default_rng([soil_seed, 1]))
        surface = outline + coat.height_mm[:, None] * self.wheel.profile.normals
        body = Revolution(WheelProfile(surface), self.wheel.radius_mm, cam_from_axle)
        cover, light = body_light(body, self.sensor.camera, self.recipe, by_chance)
        frame *= 1.0 - cover
        frame += light
        if self.laser_on:
            self._add_stripes(frame, body, coat.returns, by_chance)

    def _add_stripes(
        self, frame: Counts, body: Revolution, coat: FloatArray, by_chance: np.random.Generator
    ) -> None:
        recipe, faults = self.recipe, self.faults
        sheet = LaserSheet.of_sensor(self.sensor, by_chance, unevenness=recipe.stripe_unevenness)
        stains = coat * dirt(by_chance, len(coat), 0.05, self.physics.grain)
        for each in (sheet, *self.other_sheets):
            self._add_stripe(frame, body, each, stains, by_chance)
        if recipe.false_stripe > 0.0:
            false = sheet.reflected_through(
                _beside(body, sheet, by_chance), by_chance, power=0.5 * recipe.false_stripe
            )
            self._add_stripe(frame, body, false, stains, by_chance)
        if faults.sun_stripe > 0.0:
            sun = sun_through_slit(body, sheet, by_chance, power=faults.sun_stripe)
            self._add_stripe(frame, body, sun, stains, by_chance)
        if faults.mirror_share > 0.0:
            self._add_mirrored(frame, body, sheet)

    def _add_mirrored(self, frame: Counts, body: Revolution, sheet: LaserSheet) -> None:
        """Add what polished steel shows of the stripe."""
        camera = self.sensor.camera
        window = Window.whole(camera)
        light = mirrored_stripe(body, sheet, camera, window, self.faults.mirror_share)
        light *= np.float32(self.recipe.stripe * LASER_FOR_STEEL)
        frame += self.physics.lens.blur(light, depth_of_sheet(sheet, camera, window))

    def _add_stripe(
        self,
        frame: Counts,
        body: Revolution,
        sheet: LaserSheet,
        stains: FloatArray,
        by_chance: np.random.Generator,
    ) -> None:
        add_stripe(
            frame,
            body,
            sheet,
            stains,
            by_chance,
            camera=self.sensor.camera,
            level=self.recipe.stripe,
            physics=self.physics,
        )


def _beside(body: Revolution, sheet: LaserSheet, rng: np.random.Generator) -> FloatArray:
    """Return two points of the wheel, shape (2, 3), 10 to 30 mm beside the sheet."""
    shift_mm = rng.choice([-1.0, 1.0]) * rng.uniform(10.0, 30.0, 2)
    y = body.profile.points_mm[:, 0]
    strip = body.section(sheet.plane, sheet.source_in_cam_mm, shift_mm)
    tread = [int(np.argmin(np.abs(y[strip.place] - place))) for place in (-20.0, 45.0)]
    return strip.points_in_cam_mm[tread, [0, 1]]
