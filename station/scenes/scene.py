"""What all scenes share: surroundings, stray light, lens and sensor chip around a subject."""

from abc import ABC, abstractmethod

import numpy as np

from calib import LaserSensor, Picture
from station.scenes.light import RECIPES, Light, LightRecipe
from station.scenes.patch import Counts
from station.scenes.physics import Physics
from station.scenes.surroundings import stray_spots, surroundings


class Scene(ABC):
    """Something before a sensor in some light; its subject says what."""

    __slots__ = ()

    sensor: LaserSensor
    light: Light
    seed: int
    physics: Physics

    @property
    def recipe(self) -> LightRecipe:
        """The levels of the light."""
        return RECIPES[self.light]

    def light_counts(self) -> Counts:
        """Return the light on the sensor at exposure 1, free of noise, shape (height, width)."""
        camera = self.sensor.camera
        by_chance = np.random.default_rng(self.seed)
        frame = surroundings(camera, self.recipe, by_chance)
        self._add_subject(frame, by_chance)
        if self.recipe.stray_spots:
            frame += stray_spots(camera, self.recipe, by_chance)
        return self.physics.lens.finish(frame, camera)

    def render(self, rng: np.random.Generator, exposure: float = 1.0) -> Picture:
        """Take a picture; `rng` draws the noise and nothing else.

        Parameters
        ----------
        rng
            Source of the shot and read noise.
        exposure
            Factor on the exposure time.
        """
        return self.physics.detector.expose(self.light_counts(), rng, exposure)

    @abstractmethod
    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        """Put the subject, and the laser on it, before the surroundings."""
