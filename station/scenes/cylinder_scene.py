"""A picture of a turned cylinder, whose radius the metrologist knows."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from calib import BoolArray, FloatArray, LaserSensor, RigidTransform
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.rays import ray_map
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.texture import speckle

_MARGIN_PX = 8
_MATT = 0.6
_MOST_TILT_RAD = math.radians(20.0)
_TRIES = 2000


@dataclass(frozen=True, slots=True, eq=False)
class CylinderScene(Scene):
    """A matt cylinder before the sensor; the truth is in its own fields.

    Attributes
    ----------
    sensor
        The camera and the sheet, exact.
    cam_from_cylinder
        Its pose: z along the axis, origin in the middle.
    radius_mm, length_mm
        Its size.
    light
        The light.
    laser_on
        Whether the laser shines. A scene with the laser off is otherwise the same.
    seed
        What stands still and is left to chance: surroundings, speckle.
    physics
        Roughness, lens and sensor chip.

    Raises
    ------
    ValueError
        If a size is not positive, or the cylinder reaches behind the camera.
    """

    sensor: LaserSensor
    cam_from_cylinder: RigidTransform
    radius_mm: float = 30.0
    length_mm: float = 110.0
    light: Light = Light.GOOD
    laser_on: bool = True
    seed: int = 0
    physics: Physics = field(default_factory=Physics)

    def __post_init__(self) -> None:
        if not (self.radius_mm > 0.0 and self.length_mm > 0.0):
            raise ValueError(
                "radius_mm and length_mm must be positive, got "
                f"{self.radius_mm} and {self.length_mm}"
            )
        nearest_mm = float(self._box_in_cam_mm[:, 2].min())
        if not nearest_mm > 0.0:
            raise ValueError(
                f"the cylinder must stand before the camera; it reaches depth {nearest_mm:.1f} mm"
            )

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        camera = self.sensor.camera
        window = Window.around(camera.project(self._box_in_cam_mm), camera, margin_px=_MARGIN_PX)
        if not window.empty:
            self._add_cylinder(frame[window.slices], window, by_chance)

    @property
    def _box_in_cam_mm(self) -> FloatArray:
        signs = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T
        size = np.array([self.radius_mm, self.radius_mm, self.length_mm / 2.0])
        return self.cam_from_cylinder.apply(signs * size)

    def _add_cylinder(self, frame: Counts, window: Window, by_chance: np.random.Generator) -> None:
        points, normals, seen = self._surface(ray_map(self.sensor.camera, window))
        middle_mm = self.cam_from_cylinder.translation_mm[2]
        depth = np.where(seen, points[..., 2], middle_mm).astype(np.float32)
        level = _MATT * (self.recipe.daylight + self.recipe.sun)
        daylight = np.where(seen, level * (0.5 - 0.3 * normals[..., 1]), 0.0).astype(np.float32)
        blur = self.physics.lens.blur
        frame *= 1.0 - blur(seen.astype(np.float32), depth)
        frame += blur(daylight, depth)
        if self.laser_on:
            light = np.zeros(window.shape, dtype=np.float32)
            light[seen] = self._laser_light(points[seen], normals[seen], by_chance)
            frame += blur(light, depth) * speckle(by_chance, window.shape, self.physics.speckle)

    def _laser_light(
        self, points: FloatArray, normals: FloatArray, by_chance: np.random.Generator
    ) -> FloatArray:
        sheet = LaserSheet.of_sensor(
            self.sensor, by_chance, unevenness=self.recipe.stripe_unevenness
        )
        return self.recipe.stripe * sheet.irradiance(points, normals)

    def _surface(self, rays: NDArray[np.float32]) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return where each pixel's ray first meets the body, the normal there, and whether."""
        cylinder_from_cam = self.cam_from_cylinder.inverse()
        eye = cylinder_from_cam.translation_mm
        x, y = rays.astype(np.float64)
        sight = np.stack([x, y, np.ones_like(x)], axis=-1) @ cylinder_from_cam.rotation.T
        mantle, on_mantle = self._mantle(eye, sight)
        cap, on_cap = self._cap(eye, sight)
        met = np.where(on_cap[..., None], cap, mantle)
        flat = np.where(on_cap[..., None], 0.0, met[..., :2] / self.radius_mm)
        upright = np.where(on_cap, np.sign(eye[2]), 0.0)
        normals = np.concatenate([flat, upright[..., None]], axis=-1)
        rotation = self.cam_from_cylinder.rotation
        points = met @ rotation.T + self.cam_from_cylinder.translation_mm
        return points, normals @ rotation.T, on_mantle | on_cap

    def _mantle(self, eye: FloatArray, sight: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Meet lines of sight with the round side: the near solution of a quadratic."""
        a = (sight[..., :2] ** 2).sum(axis=-1)
        b = sight[..., :2] @ eye[:2]
        square = b * b - a * (float(eye[:2] @ eye[:2]) - self.radius_mm**2)
        depth = (-b - np.sqrt(np.maximum(square, 0.0))) / a
        met = eye + depth[..., None] * sight
        return met, (square > 0.0) & (np.abs(met[..., 2]) <= self.length_mm / 2.0)

    def _cap(self, eye: FloatArray, sight: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Meet lines of sight with the end that faces the camera, if one does."""
        end_mm = math.copysign(self.length_mm / 2.0, eye[2])
        met = eye + ((end_mm - eye[2]) / sight[..., 2])[..., None] * sight
        faces = abs(eye[2]) > self.length_mm / 2.0
        return met, faces & (np.hypot(met[..., 0], met[..., 1]) <= self.radius_mm)


def cylinder_poses(
    rng: np.random.Generator, count: int, sensor: LaserSensor, *, radius_mm: float = 30.0
) -> tuple[RigidTransform, ...]:
    """Draw poses of a cylinder that the sheet cuts across, its lit side in view.

    Parameters
    ----------
    rng
        Draws them.
    count
        How many.
    sensor
        The camera and the sheet.
    radius_mm
        Radius of the cylinder.

    Returns
    -------
    poses
        `count` maps cam_from_cylinder; the axis is up to 20 degrees from square to the sheet.

    Raises
    ------
    ValueError
        If the cylinder finds no place in the field.
    """
    return tuple(_draw_pose(rng, sensor, radius_mm) for _ in range(count))


def _draw_pose(rng: np.random.Generator, sensor: LaserSensor, radius_mm: float) -> RigidTransform:
    camera = sensor.camera
    size = np.array([camera.width, camera.height])
    upright, _ = Rotation.align_vectors(sensor.plane.normal_in_cam[None], [[0.0, 0.0, 1.0]])
    for _ in range(_TRIES):
        middle = sensor.locate(rng.uniform([0.0, 0.0], size)[None])[0]
        towards = rng.uniform(0.0, 2.0 * math.pi)
        tilt = rng.uniform(0.0, _MOST_TILT_RAD) * np.array([
            math.cos(towards),
            math.sin(towards),
            0.0,
        ])
        rotation = (upright * Rotation.from_rotvec(tilt)).as_matrix()
        reach = rotation @ (radius_mm * np.array([[1, -1, 0, 0], [0, 0, 1, -1], [0, 0, 0, 0]]))
        pixels = camera.project(middle + reach.T)
        near = 400.0 <= middle[2] <= 600.0
        if near and (pixels > 40.0).all() and (pixels < size - 40.0).all():
            return RigidTransform(rotation, middle)
    raise ValueError(f"a cylinder of radius {radius_mm} mm finds no place in the field")
