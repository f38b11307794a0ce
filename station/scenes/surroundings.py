"""What stands around the thing that is looked at, out of focus, and stray light over it all."""

import cv2
import numpy as np

from calib import CameraModel
from station.scenes.light import LightRecipe
from station.scenes.patch import Counts
from station.scenes.texture import clouds

_COARSE = 4  # the surroundings are far out of focus: a quarter of the resolution shows them


def surroundings(camera: CameraModel, recipe: LightRecipe, rng: np.random.Generator) -> Counts:
    """Return the light of what stands behind, shape of the picture.

    Ground of all sizes, and some straight things before it.
    """
    shape = (camera.height // _COARSE, camera.width // _COARSE)
    ground = 1.0 + 0.35 * clouds(rng, shape, 128.0)
    _draw_beams(ground, rng)
    light = np.float32(recipe.surroundings) * np.maximum(ground, 0.1)
    return _fine(light, camera)


def stray_spots(camera: CameraModel, recipe: LightRecipe, rng: np.random.Generator) -> Counts:
    """Return the spots that stray light and the lens throw over the whole picture."""
    light = np.zeros((camera.height // _COARSE, camera.width // _COARSE), dtype=np.float32)
    for _ in range(recipe.stray_spots):
        _add_spot(light, rng)
    return _fine(light, camera)


def _fine(light: Counts, camera: CameraModel) -> Counts:
    size = (camera.width, camera.height)
    return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_LINEAR))


def _draw_beams(ground: Counts, rng: np.random.Generator) -> None:
    """Draw the rails, posts and sleepers of a track as a few blurred beams."""
    height, width = ground.shape
    beams = np.zeros_like(ground)
    for _ in range(5):
        start = rng.uniform([0, 0], [width, height])
        angle = rng.uniform(0.0, np.pi)
        reach = (width + height) * np.array([np.cos(angle), np.sin(angle)])
        ends = [tuple(int(c) for c in start + sign * reach) for sign in (-1.0, 1.0)]
        cv2.line(beams, ends[0], ends[1], float(rng.uniform(-0.5, 0.7)), int(rng.integers(6, 30)))
    ground += cv2.GaussianBlur(beams, (0, 0), 1.5)


def _add_spot(light: Counts, rng: np.random.Generator) -> None:
    height, width = light.shape
    u, v = rng.uniform([0, 0], [width, height])
    sigma, level = rng.uniform(1.5, 6.0), rng.uniform(20.0, 260.0)
    rows = np.exp(-0.5 * ((np.arange(height) - v) / sigma) ** 2)
    columns = np.exp(-0.5 * ((np.arange(width) - u) / (sigma * rng.uniform(0.6, 2.0))) ** 2)
    light += (level * np.outer(rows, columns)).astype(np.float32)
