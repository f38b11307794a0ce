"""The laser's light on a body of steel, through the lens, put into the picture."""

import numpy as np

from calib import CameraModel, FloatArray
from station.scenes.patch import Counts, Window
from station.scenes.physics import Physics
from station.scenes.rays import ray_map
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet
from station.scenes.texture import speckle
from station.scenes.wheel_light import stripe_light

LASER_FOR_STEEL = 2.6
"""Steel returns a half of what matt white does, and a flange meets the light at 80 degrees: the
laser is set brighter for wheels than for targets."""
_MARGIN_PX = 24


def add_stripe(
    frame: Counts,
    body: Revolution,
    sheet: LaserSheet,
    stains: FloatArray,
    by_chance: np.random.Generator,
    *,
    camera: CameraModel,
    level: float,
    physics: Physics,
) -> None:
    """Add the light of one sheet on a body to a picture.

    Parameters
    ----------
    frame
        The picture.
    body, sheet
        What is lit, by what.
    stains
        Shape (S,): what each place of the profile returns, around 1.
    by_chance
        Draws the speckle.
    camera
        What sees it.
    level
        Counts of the stripe on a matt surface square to the laser.
    physics
        Lens and speckle.
    """
    middle = body.section(sheet.plane, sheet.source_in_cam_mm, np.zeros(1)).points_in_cam_mm[:, 0]
    middle = middle[middle[:, 2] > 0.0]
    if len(middle) == 0:
        return
    window = Window.around(camera.project(middle), camera, margin_px=_MARGIN_PX)
    if window.empty:
        return
    light = stripe_light(body, sheet, camera, window, stains)
    light *= np.float32(level * LASER_FOR_STEEL)
    grains = speckle(by_chance, light.shape, physics.speckle)
    frame[window.slices] += physics.lens.blur(light, depth_of_sheet(sheet, camera, window)) * grains


def depth_of_sheet(sheet: LaserSheet, camera: CameraModel, window: Window) -> Counts:
    """Return how far away the sheet is in each pixel of a window, mm."""
    rays = ray_map(camera, window)
    a, b, c = sheet.plane.normal_in_cam.astype(np.float32)
    return np.asarray(-np.float32(sheet.plane.offset_mm) / (a * rays[0] + b * rays[1] + c))
