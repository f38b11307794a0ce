"""A picture of the calibration target, crossed by the laser."""

from dataclasses import dataclass, field, replace

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform, Target
from station.scenes.board import Appearance, appearance
from station.scenes.board_light import BoardView, false_sheet, standing_light
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.placed_board import PlacedBoard
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
    dot_shift_mm
        As in `PlacedBoard`.
    beside
        Other boards, behind or beside this one; those that show their backs, or are seen edge on,
        stay dark.

    Raises
    ------
    ValueError
        If a corner of the board lies behind the camera, the board shows its back, or dots are
        displaced so far that they may touch.
    """

    sensor: LaserSensor
    target: Target
    cam_from_board: RigidTransform
    light: Light = Light.GOOD
    laser_on: bool = True
    seed: int = 0
    physics: Physics = field(default_factory=Physics)
    dot_shift_mm: FloatArray | None = None
    beside: tuple[PlacedBoard, ...] = ()

    def __post_init__(self) -> None:
        if not self.board.shows_its_front:
            raise ValueError(
                "the board must stand before the camera and face it (z away from the camera); got "
                f"its nearest corner at depth {self.board.corners_in_cam_mm[:, 2].min():.1f} mm"
            )

    @property
    def board(self) -> PlacedBoard:
        """The target as it is placed."""
        return PlacedBoard(self.target, self.cam_from_board, self.dot_shift_mm)

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        for number, other in enumerate(self.beside):
            if other.shows_its_front and not other.is_edge_on:
                self._add_board(frame, other, np.random.default_rng([self.seed, number]))
        self._add_board(frame, self.board, by_chance)

    def _add_board(self, frame: Counts, board: PlacedBoard, by_chance: np.random.Generator) -> None:
        camera = self.sensor.camera
        corners_px = camera.project(board.corners_in_cam_mm)
        window = Window.around(corners_px, camera, margin_px=_BLUR_MARGIN_PX)
        if window.empty:
            return
        view = BoardView.of(camera, board.cam_from_board, window)
        look = appearance(board.target, view.place, self.physics.grain, board.dot_shift_mm)
        if not board.lit:
            look = replace(look, lamps=np.zeros_like(look.lamps))
        light = standing_light(board.target, look, view.place, self.recipe, by_chance)
        frame[window.slices] *= 1.0 - self.physics.lens.blur(look.board, view.depth_mm)
        frame[window.slices] += self.physics.lens.blur(light, view.depth_mm)
        if self.laser_on:
            frame[window.slices] += self._stripes(board, view, look, by_chance)

    def _stripes(
        self,
        board: PlacedBoard,
        view: BoardView,
        look: Appearance,
        by_chance: np.random.Generator,
    ) -> Counts:
        """Return the light of the true stripe and, where the light has one, of the false."""
        sheet = LaserSheet.of_sensor(
            self.sensor, by_chance, unevenness=self.recipe.stripe_unevenness
        )
        light = view.laser_light(sheet, look)
        if self.recipe.false_stripe > 0.0:
            false = false_sheet(
                sheet,
                board.target,
                board.cam_from_board,
                by_chance,
                power=self.recipe.false_stripe,
            )
            if false is not None:
                light += view.laser_light(false, look)
        light *= np.float32(self.recipe.stripe)
        grains = speckle(by_chance, light.shape, self.physics.speckle)
        return self.physics.lens.blur(light, view.depth_mm) * grains
