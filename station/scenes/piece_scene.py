"""A picture of a reference piece held in the sheet, whose profile the metrologist knows."""

from dataclasses import dataclass, field

import numpy as np

from calib import BoolArray, FloatArray, LaserSensor, RigidTransform, SheetFrame
from measure import Piece
from station.scenes.installation import projector_in_cam_mm
from station.scenes.light import Light
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.prism import Prism
from station.scenes.rays import ray_map
from station.scenes.scene import Scene
from station.scenes.sheet import LaserSheet
from station.scenes.texture import speckle

_MARGIN_PX = 8
_MATT = 0.6
_LIT = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class PieceScene(Scene):
    """A matt prism before the sensor; the truth is in its own fields.

    Attributes
    ----------
    sensor
        The camera and the sheet, exact.
    cam_from_piece
        Its pose: profile in x and z, y along the prism, origin in the middle of its length.
    piece
        Its profile.
    length_mm
        Of the prism.
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
        If the length is not positive, or the piece reaches behind the camera.
    """

    sensor: LaserSensor
    cam_from_piece: RigidTransform
    piece: Piece
    length_mm: float = 40.0
    light: Light = Light.GOOD
    laser_on: bool = True
    seed: int = 0
    physics: Physics = field(default_factory=Physics)

    def __post_init__(self) -> None:
        if not self.length_mm > 0.0:
            raise ValueError(f"length_mm must be positive, got {self.length_mm}")
        nearest_mm = float(self._outline_in_cam_mm[:, 2].min())
        if not nearest_mm > 0.0:
            raise ValueError(
                f"the piece must lie before the camera; it reaches depth {nearest_mm:.1f} mm"
            )

    @property
    def _outline_in_cam_mm(self) -> FloatArray:
        profile, _ = self.piece.samples(2.0)
        both = np.concatenate([profile, self.piece.corners_mm])
        ends = [
            np.column_stack([both[:, 0], np.full(len(both), end), both[:, 1]])
            for end in (-0.5 * self.length_mm, 0.5 * self.length_mm)
        ]
        return self.cam_from_piece.apply(np.concatenate(ends))

    def _add_subject(self, frame: Counts, by_chance: np.random.Generator) -> None:
        camera = self.sensor.camera
        window = Window.around(
            camera.project(self._outline_in_cam_mm), camera, margin_px=_MARGIN_PX
        )
        if not window.empty:
            self._add_piece(frame[window.slices], window, by_chance)

    def _add_piece(self, frame: Counts, window: Window, by_chance: np.random.Generator) -> None:
        prism = Prism(self.piece.faces, self.length_mm)
        points, normals, seen = self._surface(prism, window)
        middle_mm = self.cam_from_piece.translation_mm[2]
        depth = np.where(seen, points[..., 2], middle_mm).astype(np.float32)
        level = _MATT * (self.recipe.daylight + self.recipe.sun)
        daylight = np.where(seen, level * (0.5 - 0.3 * normals[..., 1]), 0.0).astype(np.float32)
        blur = self.physics.lens.blur
        frame *= 1.0 - blur(seen.astype(np.float32), depth)
        frame += blur(daylight, depth)
        if self.laser_on:
            light = np.zeros(window.shape, dtype=np.float32)
            light[seen] = self._laser_light(prism, points[seen], normals[seen], by_chance)
            frame += blur(light, depth) * speckle(by_chance, window.shape, self.physics.speckle)

    def _surface(self, prism: Prism, window: Window) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return where each pixel's ray first meets the piece, the normal there, and whether."""
        piece_from_cam = self.cam_from_piece.inverse()
        x, y = ray_map(self.sensor.camera, window).astype(np.float64)
        sight = np.stack([x, y, np.ones_like(x)], axis=-1) @ piece_from_cam.rotation.T
        met, normals, seen = prism.met(piece_from_cam.translation_mm, sight)
        rotation = self.cam_from_piece.rotation
        return met @ rotation.T + self.cam_from_piece.translation_mm, normals @ rotation.T, seen

    def _laser_light(
        self,
        prism: Prism,
        points: FloatArray,
        normals: FloatArray,
        by_chance: np.random.Generator,
    ) -> FloatArray:
        sheet = LaserSheet.of_sensor(
            self.sensor, by_chance, unevenness=self.recipe.stripe_unevenness
        )
        light = self.recipe.stripe * sheet.irradiance(points, normals)
        lit = np.flatnonzero(light > _LIT)
        piece_from_cam = self.cam_from_piece.inverse()
        source = piece_from_cam.apply(sheet.source_in_cam_mm[None])[0]
        shaded = prism.shaded(source, piece_from_cam.apply(points[lit]))
        light[lit[shaded]] = 0.0
        return np.asarray(light)


def piece_pose(
    sensor: LaserSensor,
    piece: Piece,
    *,
    middle_px: tuple[float, float],
    turn_rad: float = 0.0,
    slant_rad: tuple[float, float] = (0.0, 0.0),
) -> RigidTransform:
    """Return cam_from_piece of a piece held in the sheet, its lit sides towards the camera.

    Parameters
    ----------
    sensor
        The camera and the sheet.
    piece
        What is held.
    middle_px
        Where the middle of its edges is seen.
    turn_rad
        In the sheet, from where its z points to the middle between camera and laser.
    slant_rad
        How far the prism leans from square to the sheet, about its x and about its z.
    """
    frame = SheetFrame.of(sensor.plane)
    middle = sensor.locate(np.array([middle_px]))[0]
    eye = 0.5 * (sensor.plane.offset_mm * -sensor.plane.normal_in_cam + projector_in_cam_mm(sensor))
    up = frame.coordinates(eye) - frame.coordinates(middle)
    angle = np.arctan2(up[1], up[0]) + turn_rad
    z = np.array([np.cos(angle), np.sin(angle)]) @ frame.axes_in_cam
    y = sensor.plane.normal_in_cam
    rotation = np.column_stack([np.cross(y, z), y, z])
    about_x, about_z = slant_rad
    lean = RigidTransform.from_rotation_vector([about_x, 0.0, about_z], np.zeros(3))
    rotation = rotation @ lean.rotation
    x_mm, z_mm = piece.corners_mm.mean(axis=0)
    return RigidTransform(rotation, middle - rotation @ np.array([x_mm, 0.0, z_mm]))
