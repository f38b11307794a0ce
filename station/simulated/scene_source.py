"""A camera before a rendered scene: the paper's target, a worn wheel, a cylinder."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from calib import CameraModel, Picture, Target
from station.progress import Progress
from station.scenes import (
    CylinderScene,
    Light,
    Physics,
    TargetScene,
    WheelScene,
    WheelTruth,
    cylinder_poses,
    paper_sensor,
    target_scenes,
    trackside_mounting,
)
from station.simulated.registers import DEFAULT_EXPOSURE_US
from station.simulated.scene_kind import SceneKind

PAPER_TARGET = Target("dots", rows=7, cols=8, pitch_mm=12.0, diameter_mm=6.0)
SCENES = 12
_AXLE_OFFSETS_MM = (-12.0, 0.0, 12.0)
_MOST_TREAD_WEAR_MM = 4.0
_MOST_FLANGE_WEAR_MM = 3.0


class Scene(Protocol):
    """What every rendered scene can do."""

    @property
    def physics(self) -> Physics:
        """Roughness, lens and sensor chip."""

    def light_counts(self) -> NDArray[np.float32]:
        """Return the light on the sensor at exposure 1, free of noise."""


class RenderedScenes:
    """Serves scenes one after another, over and over, each rendered beforehand.

    Rendering takes longer than the camera's period, so that a scene's picture, noise included,
    is the same each time it comes round. When exposure or gain change, the pictures are taken
    anew from the light already computed. Each scene stands for `frames_per_scene` pictures: as
    long as an exposure sequence takes.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        camera: CameraModel,
        *,
        seed: int,
        progress: Progress,
        frames_per_scene: int = 1,
    ) -> None:
        self.width, self.height = camera.width, camera.height
        self._scenes = scenes
        self._seed = seed
        self._lights: list[NDArray[np.float32]] = []
        for done, scene in enumerate(scenes, start=1):
            self._lights.append(scene.light_counts())
            progress(done / len(scenes), f"scene {done} of {len(scenes)}")
        self._lights_laser_off: dict[int, NDArray[np.float32]] = {}
        self._frames_per_scene = frames_per_scene
        self._exposure = 1.0
        self._pictures: dict[int, Picture] = {}
        for place in range(len(scenes)):
            self.frame(place * frames_per_scene, DEFAULT_EXPOSURE_US)

    def frame(self, index: int, exposure_us: float) -> Picture:
        exposure = exposure_us / DEFAULT_EXPOSURE_US
        if exposure != self._exposure:
            self._exposure = exposure
            self._pictures.clear()
        place = self._place(index)
        if place not in self._pictures:
            rng = np.random.default_rng([self._seed, place])
            self._pictures[place] = self._exposed(place, self._lights[place], rng, exposure)
        return self._pictures[place]

    def frame_laser_off(self, index: int, exposure_us: float) -> Picture:
        """Return the same scene with the laser off; where it cannot be, as it is."""
        place = self._place(index)
        scene = self._scenes[place]
        if not isinstance(scene, TargetScene):
            return self.frame(index, exposure_us)
        if place not in self._lights_laser_off:
            self._lights_laser_off[place] = replace(scene, laser_on=False).light_counts()
        rng = np.random.default_rng([self._seed, place, index])
        light = self._lights_laser_off[place]
        return self._exposed(place, light, rng, exposure_us / DEFAULT_EXPOSURE_US)

    def _place(self, index: int) -> int:
        return index // self._frames_per_scene % len(self._lights)

    def _exposed(
        self, place: int, light: NDArray[np.float32], rng: np.random.Generator, exposure: float
    ) -> Picture:
        return self._scenes[place].physics.detector.expose(light, rng, exposure)


def render_dozen(
    kind: SceneKind, light: Light, seed: int, progress: Progress, frames_per_scene: int = 1
) -> RenderedScenes:
    """Render a dozen scenes of a kind; see `render_scenes`."""
    makers: dict[SceneKind, Callable[[np.random.Generator, Light], Sequence[Scene]]] = {
        SceneKind.TARGET: _targets,
        SceneKind.WHEEL: _wheels,
        SceneKind.CYLINDER: _cylinders,
    }
    scenes = makers[kind](np.random.default_rng(seed), light)
    return RenderedScenes(
        scenes,
        paper_sensor().camera,
        seed=seed,
        progress=progress,
        frames_per_scene=frames_per_scene,
    )


def _targets(rng: np.random.Generator, light: Light) -> Sequence[TargetScene]:
    return target_scenes(rng, paper_sensor(), PAPER_TARGET, [light] * SCENES)


def _wheels(rng: np.random.Generator, light: Light) -> Sequence[WheelScene]:
    mounting = trackside_mounting("left")
    wheels = [
        WheelTruth(
            tread_wear_mm=rng.uniform(0.0, _MOST_TREAD_WEAR_MM),
            flange_wear_mm=rng.uniform(0.0, _MOST_FLANGE_WEAR_MM),
        )
        for _ in range(SCENES // len(_AXLE_OFFSETS_MM))
    ]
    return [
        WheelScene(
            paper_sensor(),
            mounting,
            wheel,
            axle_offset_mm=offset_mm,
            light=light,
            seed=int(rng.integers(2**32)),
        )
        for wheel in wheels
        for offset_mm in _AXLE_OFFSETS_MM
    ]


def _cylinders(rng: np.random.Generator, light: Light) -> Sequence[CylinderScene]:
    return [
        CylinderScene(paper_sensor(), pose, light=light, seed=int(rng.integers(2**32)))
        for pose in cylinder_poses(rng, SCENES, paper_sensor())
    ]
