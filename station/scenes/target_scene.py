"""A picture of the calibration target, crossed by the laser."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calib import FloatArray, LaserSensor, Picture, RigidTransform, Target
from station.scenes.board import Appearance, BoardMap, appearance, outline_mm
from station.scenes.detector import Detector
from station.scenes.light import RECIPES, Light, LightRecipe
from station.scenes.optics import Lens
from station.scenes.patch import Counts, Window
from station.scenes.rays import ray_map
from station.scenes.sheet import LaserSheet
from station.scenes.surroundings import surroundings
from station.scenes.texture import speckle

_BLUR_MARGIN_PX = 8


@dataclass(frozen=True, slots=True)
class Surface:
    """How rough what is looked at is; `smooth` takes all of it away, for tests of the geometry.

    Attributes
    ----------
    grain
        Standard deviation over mean of the light a surface returns.
    speckle
        Contrast of the laser's speckle, as the pixels see it.
    """

    grain: float = 0.12
    speckle: float = 0.09

    @classmethod
    def smooth(cls) -> "Surface":
        """Make a surface without grain and speckle."""
        return cls(grain=0.0, speckle=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class TargetScene:
    """The target before the sensor in one pose; the truth is in its own fields.

    Attributes
    ----------
    sensor
        The camera and the sheet, exact.
    target
        The target; dots glow unless they are printed (`dark`).
    cam_from_board
        Its pose.
    light
        The light. ``Light.CROSSING`` is a strong laser; the pose decides what it crosses
        (`pose_through_dots`).
    laser_on
        Whether the laser shines. A scene with the laser off is otherwise the same.
    seed
        What stands still and is left to chance: glare, surroundings, speckle.
    surface, lens, detector
        The physics.

    Raises
    ------
    ValueError
        If a corner of the board lies behind the camera, or the board shows its back.
    """

    sensor: LaserSensor
    target: Target
    cam_from_board: RigidTransform
    light: Light = Light.GOOD
    laser_on: bool = True
    seed: int = 0
    surface: Surface = field(default_factory=Surface)
    lens: Lens = field(default_factory=Lens)
    detector: Detector = field(default_factory=Detector)

    def __post_init__(self) -> None:
        corners = self._corners_in_cam_mm
        facing = -float(self.cam_from_board.rotation[:, 2] @ self.cam_from_board.translation_mm)
        if not (corners[:, 2].min() > 0.0 and facing < 0.0):
            raise ValueError(
                "the board must stand before the camera and face it (z away from the camera); got "
                f"its nearest corner at depth {corners[:, 2].min():.1f} mm"
            )

    @property
    def recipe(self) -> LightRecipe:
        """The levels of the light."""
        return RECIPES[self.light]

    def light_counts(self) -> Counts:
        """Return the light on the sensor at exposure 1, free of noise, shape (height, width)."""
        camera = self.sensor.camera
        by_chance = np.random.default_rng(self.seed)
        frame = surroundings(camera, self.recipe, by_chance)
        window = Window.around(
            camera.project(self._corners_in_cam_mm), camera, margin_px=_BLUR_MARGIN_PX
        )
        if not window.empty:
            self._add_board(frame[window.slices], window, by_chance)
        return self.lens.finish(frame, camera)

    def render(self, rng: np.random.Generator, exposure: float = 1.0) -> Picture:
        """Take a picture; `rng` draws the noise and nothing else.

        Parameters
        ----------
        rng
            Source of the shot and read noise.
        exposure
            Factor on the exposure time.
        """
        return self.detector.expose(self.light_counts(), rng, exposure)
