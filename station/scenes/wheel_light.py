"""The light that comes from a wheel: what the laser throws on its rim, and daylight on its body."""

import cv2
import numpy as np

from calib import CameraModel, FloatArray
from station.scenes.light import LightRecipe
from station.scenes.patch import Counts, Window
from station.scenes.rays import ray_map
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet
from station.scenes.steel import returned

_ACROSS_STEP_MM = 0.05  # as the profile's: about 4 x 4 samples on a pixel
_BODY_SCALE = 8


def stripe_light(
    wheel: Revolution, sheet: LaserSheet, camera: CameraModel, window: Window, dirt: FloatArray
) -> Counts:
    """Return the laser's light on a wheel, sharp, in a window of the picture.

    Parameters
    ----------
    wheel, sheet, camera
        What is lit, by what, seen by what.
    window
        The pixels wanted.
    dirt
        Shape (S,): what each place of the profile returns, around 1.

    Returns
    -------
    light
        Shape of the window: 1 where matt white faces the laser.

    Notes
    -----
    The strip of surface that the sheet lights is laid out as a grid of small pieces. Each sends
    its brightness times the area of its picture to the pixels where it is seen, so that a
    surface seen at a grazing angle is right without any special case.
    """
    across = np.arange(-sheet.reach_mm, sheet.reach_mm + _ACROSS_STEP_MM, _ACROSS_STEP_MM)
    strip = wheel.section(sheet.plane, sheet.source_in_cam_mm, across)
    middle = strip.points_in_cam_mm[:, len(across) // 2]
    seen = wheel.sees(middle, np.zeros(3)) & wheel.sees(middle, sheet.source_in_cam_mm)
    if np.count_nonzero(seen) < 2:
        return np.zeros(window.shape, dtype=np.float32)

    pixels = camera.project(strip.points_in_cam_mm.reshape(-1, 3))
    pixels = pixels.reshape(*strip.points_in_cam_mm.shape[:2], 2)
    areas = areas_px(pixels)[seen]
    # Over the millimetre of the sheet's thickness the wheel turns by 0.1 degrees: what steel
    # returns is the same all across.
    share = returned(
        wheel.profile.points_mm[strip.place[seen], 0],
        strip.normals_in_cam[seen, len(across) // 2],
        _towards(sheet.source_in_cam_mm, middle[seen]),
        _towards(np.zeros(3), middle[seen]),
    )
    bright = sheet.irradiance(
        strip.points_in_cam_mm[seen].reshape(-1, 3), strip.normals_in_cam[seen].reshape(-1, 3)
    ).reshape(areas.shape)
    bright *= (share * dirt[strip.place[seen]])[:, None]
    return splat(pixels[seen], bright * areas, window)


def body_light(
    wheel: Revolution, camera: CameraModel, recipe: LightRecipe, rng: np.random.Generator
) -> tuple[Counts, Counts]:
    """Return the share of each pixel that the wheel fills and its light by day, without laser.

    Parameters
    ----------
    wheel, camera
        What is seen, by what.
    recipe
        The light.
    rng
        Draws where the sun stands.

    Returns
    -------
    cover, light
        Shape of the picture each. Worked out in blocks of 8 x 8 pixels: the wheel's body is not
        measured, it only stands behind the stripe.
    """
    window = Window.whole(camera)
    half = _BODY_SCALE // 2
    rays = ray_map(camera, window)[:, half::_BODY_SCALE, half::_BODY_SCALE]
    shape = rays.shape[1:]
    directions = np.column_stack([rays[0].ravel(), rays[1].ravel(), np.ones(rays[0].size)])
    points, normals = wheel.first_hit(directions.astype(np.float64))
    hit = np.isfinite(points[:, 0])
    light = np.zeros(len(points), dtype=np.float32)
    if hit.any():
        light[hit] = _daylight(points[hit], normals[hit], recipe, rng)
    cover = hit.reshape(shape).astype(np.float32)
    return _fine(cover, camera), _fine(light.reshape(shape), camera)


def _daylight(
    points: FloatArray, normals: FloatArray, recipe: LightRecipe, rng: np.random.Generator
) -> FloatArray:
    """Return sky, sun and the sun's reflection on steel seen from the camera."""
    to_eye = _towards(np.zeros(3), points)
    sky = 0.3 * (0.6 + 0.4 * -normals[:, 1])
    # The sun stands where its reflection falls on some part of the rim in view.
    mirror = normals[rng.integers(len(normals))] + rng.normal(scale=0.05, size=3)
    mirror /= np.linalg.norm(mirror)
    eye = to_eye.mean(axis=0)
    sun = 2.0 * (mirror @ eye) * mirror - eye
    lit = 0.3 * np.maximum(normals @ sun, 0.0)
    halfway = to_eye + sun
    halfway /= np.linalg.norm(halfway, axis=1, keepdims=True)
    glare = np.maximum((normals * halfway).sum(axis=1), 0.0) ** 150.0
    return np.asarray(recipe.daylight * sky + recipe.sun * lit + recipe.shine * glare)


def _fine(coarse: Counts, camera: CameraModel) -> Counts:
    soft = cv2.GaussianBlur(coarse, (0, 0), 0.8)
    return np.asarray(cv2.resize(soft, (camera.width, camera.height)))


def _towards(eye_in_cam_mm: FloatArray, points: FloatArray) -> FloatArray:
    way = eye_in_cam_mm - points
    return np.asarray(way / np.linalg.norm(way, axis=-1, keepdims=True))


def areas_px(pixels: FloatArray) -> FloatArray:
    """Return the area of the picture of each piece of a grid, shape (S, Q), px²."""
    along, across = np.gradient(pixels, axis=0), np.gradient(pixels, axis=1)
    return np.asarray(np.abs(along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]))


def splat(pixels: FloatArray, light: FloatArray, window: Window) -> Counts:
    """Share light out over the four pixels around each place, shape (..., 2)."""
    height, width = window.shape
    u = pixels[..., 0].ravel() - window.left
    v = pixels[..., 1].ravel() - window.top
    inside = (u >= 0.0) & (u < width - 1.0) & (v >= 0.0) & (v < height - 1.0)
    u, v, weight = u[inside], v[inside], light.ravel()[inside]
    column, row = np.floor(u).astype(np.intp), np.floor(v).astype(np.intp)
    right, down = u - column, v - row
    place = row * width + column
    frame = np.zeros(height * width)
    for step, share in (
        (0, (1.0 - right) * (1.0 - down)),
        (1, right * (1.0 - down)),
        (width, (1.0 - right) * down),
        (width + 1, right * down),
    ):
        frame += np.bincount(place + step, weights=weight * share, minlength=height * width)
    return frame.reshape(height, width).astype(np.float32)
