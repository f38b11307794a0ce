"""A picture of the calibration target, crossed by the laser."""

from dataclasses import dataclass, field

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform, Target
from station.scenes.board import Appearance, appearance, outline_mm
from station.scenes.board_light import BoardView, false_sheet, standing_light
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.texture import speckle

_BLUR_MARGIN_PX = 8


@dataclass(frozen=True, slots=True, eq=False)
class TargetScene(Scene):
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
    physics
        Roughness, lens and sensor chip.

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
    physics: Physics = field(default_factory=Physics)

    def __post_init__(self) -> None:
        corners = self._corners_in_cam_mm
        facing = -float(self.cam_from_board.rotation[:, 2] @ self.cam_from_board.translation_mm)
        if not (corners[:, 2].min() > 0.0 and facing < 0.0):
            raise ValueError(
                "the board must stand before the camera and face it (z away from the camera); got "
                f"its nearest corner at depth {corners[:, 2].min():.1f} mm"
            )

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        camera = self.sensor.camera
        window = Window.around(
            camera.project(self._corners_in_cam_mm), camera, margin_px=_BLUR_MARGIN_PX
        )
        if not window.empty:
            self._add_board(frame[window.slices], window, by_chance)

    @property
    def _corners_in_cam_mm(self) -> FloatArray:
        (left, top), (right, bottom) = outline_mm(self.target)
        corners = [[left, top, 0], [right, top, 0], [right, bottom, 0], [left, bottom, 0]]
        return self.cam_from_board.apply(np.array(corners, dtype=np.float64))

    def _add_board(self, frame: Counts, window: Window, by_chance: np.random.Generator) -> None:
        view = BoardView.of(self.sensor.camera, self.cam_from_board, window)
        look = appearance(self.target, view.place, self.physics.grain)
        board = standing_light(self.target, look, view.place, self.recipe, by_chance)
        frame *= 1.0 - self.physics.lens.blur(look.board, view.depth_mm)
        frame += self.physics.lens.blur(board, view.depth_mm)
        if self.laser_on:
            frame += self._stripes(view, look, by_chance)

    def _stripes(self, view: BoardView, look: Appearance, by_chance: np.random.Generator) -> Counts:
        """Return the light of the true stripe and, where the light has one, of the false."""
        sheet = LaserSheet.of_sensor(
            self.sensor, by_chance, unevenness=self.recipe.stripe_unevenness
        )
        light = view.laser_light(sheet, look)
        if self.recipe.false_stripe > 0.0:
            false = false_sheet(
                sheet, self.target, self.cam_from_board, by_chance, power=self.recipe.false_stripe
            )
            if false is not None:
                light += view.laser_light(false, look)
        light *= np.float32(self.recipe.stripe)
        grains = speckle(by_chance, light.shape, self.physics.speckle)
        return self.physics.lens.blur(light, view.depth_mm) * grains
