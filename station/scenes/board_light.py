"""The light that comes from the target: its lamps, daylight, reflections, and the laser on it."""

from dataclasses import dataclass

import numpy as np

from calib import CameraModel, FloatArray, RigidTransform, Target
from station.scenes.board import Appearance, BoardMap, outline_mm
from station.scenes.crossing import crossing_on_board
from station.scenes.light import LightRecipe
from station.scenes.patch import Counts, Window
from station.scenes.rays import ray_map
from station.scenes.sheet import LaserSheet


@dataclass(frozen=True, slots=True, eq=False)
class BoardView:
    """A window of the picture filled by the plane of the board.

    Attributes
    ----------
    ray_x, ray_y
        Shape (rows, columns): x/z and y/z of each pixel's ray.
    depth_mm
        Shape (rows, columns): z in the camera frame where the ray meets the plane.
    place
        The same places in TCF.
    normal_in_cam
        Shape (3,): the board's normal, towards the camera.
    """

    ray_x: Counts
    ray_y: Counts
    depth_mm: Counts
    place: BoardMap
    normal_in_cam: FloatArray

    @classmethod
    def of(cls, camera: CameraModel, cam_from_board: RigidTransform, window: Window) -> "BoardView":
        """Meet the rays of a window with the plane of the board."""
        x, y = ray_map(camera, window)
        rotation, origin = cam_from_board.rotation, cam_from_board.translation_mm
        # (x_board, y_board, 1) / z = inverse of [r1 r2 t] times the ray: Eq. 10 turned round.
        inverse = np.linalg.inv(np.column_stack([rotation[:, :2], origin])).astype(np.float32)
        depth = 1.0 / (inverse[2, 0] * x + inverse[2, 1] * y + inverse[2, 2])
        place = BoardMap.of(
            depth * (inverse[0, 0] * x + inverse[0, 1] * y + inverse[0, 2]),
            depth * (inverse[1, 0] * x + inverse[1, 1] * y + inverse[1, 2]),
        )
        return cls(x, y, depth, place, -rotation[:, 2])

    def laser_light(self, sheet: LaserSheet, look: Appearance) -> Counts:
        """Return what a sheet throws on the board: 1 for metal square to the laser's middle."""
        a, b, c = sheet.plane.normal_in_cam.astype(np.float32)
        distance = self.depth_mm * (a * self.ray_x + b * self.ray_y + c)
        distance += np.float32(sheet.plane.offset_mm)
        lit = (np.abs(distance) < sheet.reach_mm) & (look.board > 0.0)
        depth = self.depth_mm[lit].astype(np.float64)
        points = np.column_stack([depth * self.ray_x[lit], depth * self.ray_y[lit], depth])
        light = np.zeros(distance.shape, dtype=np.float32)
        light[lit] = sheet.irradiance(points, self.normal_in_cam)
        light *= look.laser * look.board
        return light


def standing_light(
    target: Target,
    look: Appearance,
    place: BoardMap,
    recipe: LightRecipe,
    rng: np.random.Generator,
) -> Counts:
    """Return all the light of the board but the laser's: lamps, daylight, sun and shine."""
    low, high = outline_mm(target)
    size = high - low
    across_x = (place.x_mm - np.float32(low[0])) / np.float32(size[0])
    across_y = (place.y_mm - np.float32(low[1])) / np.float32(size[1])
    lamps = recipe.lamps * look.lamps * _fall(across_x, across_y, recipe.lamps_fall, rng)
    daylight = recipe.daylight + recipe.sun * _sunlit(across_x, across_y, rng)
    light = lamps + daylight * look.white
    shine = _shine(across_x, across_y, look.grain, rng)
    # A diffuser returns a third of the shine, and to all sides; printed boards are matt as well.
    light += recipe.shine * shine * (0.3 + 0.7 * look.metal)
    return np.asarray(light * look.board, dtype=np.float32)


def false_sheet(
    sheet: LaserSheet,
    target: Target,
    cam_from_board: RigidTransform,
    rng: np.random.Generator,
    *,
    power: float,
) -> LaserSheet | None:
    """Return a reflected sheet that crosses the board beside the true one, or None."""
    centre = outline_mm(target).mean(axis=0)
    crossing = crossing_on_board(sheet.plane, cam_from_board, centre)
    if crossing is None:
        return None
    half = 0.5 * (target.cols - 1) * target.pitch_mm
    beside = np.array([-crossing.direction[1], crossing.direction[0]])
    # On the side where there is more board, one to three pitches away, a few degrees turned.
    side = 1.0 if (centre - crossing.nearest_mm) @ beside >= 0.0 else -1.0
    shifts_mm = (
        side * target.pitch_mm * (rng.uniform(1.0, 3.0) + np.array([-0.5, 0.5]) * rng.normal())
    )
    ends = crossing.nearest_mm + np.outer([-half, half], crossing.direction)
    ends += np.outer(shifts_mm, beside)
    ends_in_cam = cam_from_board.apply(np.column_stack([ends, np.zeros(2)]))
    return sheet.reflected_through(ends_in_cam, rng, power=power)


def _fall(across_x: Counts, across_y: Counts, share: float, rng: np.random.Generator) -> Counts:
    """Return 1 on one side of the board, falling to 1 - share on the other."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    along = np.cos(angle) * (across_x - 0.5) + np.sin(angle) * (across_y - 0.5)
    return np.asarray(1.0 - share * np.clip(0.5 + along, 0.0, 1.0), dtype=np.float32)


def _sunlit(across_x: Counts, across_y: Counts, rng: np.random.Generator) -> Counts:
    """Return 1 in the sun and 0.15 in the shadow whose soft edge crosses the board."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    offset = rng.uniform(-0.25, 0.25)
    along = np.cos(angle) * (across_x - 0.5) + np.sin(angle) * (across_y - 0.5) - offset
    return np.asarray(0.575 + 0.425 * np.tanh(along / 0.04), dtype=np.float32)


def _shine(across_x: Counts, across_y: Counts, grain: Counts, rng: np.random.Generator) -> Counts:
    """Return the picture of a lamp or the sun in rough metal: a patch of a third of the board."""
    x0, y0 = rng.uniform(0.2, 0.8, 2)
    angle = rng.uniform(0.0, np.pi)
    long, short = rng.uniform(0.3, 0.45), rng.uniform(0.16, 0.26)
    along = (np.cos(angle) * (across_x - x0) + np.sin(angle) * (across_y - y0)) / long
    aside = (-np.sin(angle) * (across_x - x0) + np.cos(angle) * (across_y - y0)) / short
    patch = np.exp(-((along**2 + aside**2) ** 1.5))
    return np.asarray(patch * np.maximum(1.0 + 0.3 * grain, 0.0), dtype=np.float32)
