"""The stripe seen a second time in polished steel: the flange mirrors the tread, and the tread it.

Light of the laser that the tread scatters meets the polished throat and face of the flange, and
from there the camera. A sheet that cuts the wheel radially stays in its plane when steel mirrors
it, so that the laser's own way over the flange lights no second place; the camera looks along
another plane, and what it sees mirrored lies beside the stripe.
"""

from dataclasses import replace

import numpy as np

from calib import BoolArray, CameraModel, FloatArray
from station.scenes.patch import Counts, Window
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet
from station.scenes.wheel_light import areas_px, splat

_AROUND_MM = np.arange(-70.0, 70.01, 0.2)
_EVERY = 4  # points of the profile, 0.05 mm apart, are one patch of mirror
# The contact with the rail polishes flange face, throat and tread; places y, share that mirrors.
_PLACES_MM = (-56.0, -48.0, -42.0, -30.0, -20.0, 20.0, 35.0)
_POLISH = (0.0, 0.4, 1.0, 1.0, 0.5, 0.35, 0.0)
_SLOPES_RAD = 0.012
"""How uneven polished steel is: what it mirrors from afar is smeared by twice the angle."""
_FAR_MM, _FARTHEST_MM = 25.0, 100.0


def mirrored_stripe(
    wheel: Revolution,
    sheet: LaserSheet,
    camera: CameraModel,
    window: Window,
    mirror_share: float,
) -> Counts:
    r"""Return the laser's light on a wheel as the wheel itself mirrors it to the camera.

    Parameters
    ----------
    wheel, sheet, camera
        What is lit, by what, seen by what.
    window
        The pixels wanted.
    mirror_share
        Share of the light that the best polished place mirrors.

    Returns
    -------
    light
        Shape of the window, on the scale of `stripe_light`.

    Notes
    -----
    The polished surface is laid out in patches. From each the line of sight goes on at the
    mirrored angle, :math:`d - 2 (d \cdot n) n`, and shows what it meets: the brightness of the
    sheet there, smeared by the unevenness of the mirror.
    """
    points, normals, polish = _patches(wheel, sheet)
    pixels = camera.project(points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    areas = areas_px(pixels)
    sight = points / np.linalg.norm(points, axis=2, keepdims=True)
    onward = sight - 2.0 * np.sum(sight * normals, axis=2, keepdims=True) * normals
    near = _towards_stripe(points, onward, sheet)
    near[near] = wheel.sees(points[near], np.zeros(3))
    met, normals_there = wheel.next_hit(points[near], onward[near])
    hit = np.isfinite(met[:, 0])
    smear_mm = float(np.hypot(sheet.sigma_mm, 2.0 * _FAR_MM * _SLOPES_RAD))
    blurred = replace(sheet, sigma_mm=smear_mm, power=sheet.power * sheet.sigma_mm / smear_mm)
    bright = np.zeros(len(met))
    bright[hit] = blurred.irradiance(met[hit], normals_there[hit])
    share = mirror_share * np.broadcast_to(polish[:, None], areas.shape)
    return splat(pixels[near], bright * (share * areas)[near], window)


def _towards_stripe(points: FloatArray, onward: FloatArray, sheet: LaserSheet) -> BoolArray:
    """Tell which lines of sight, shape (S, T), go on to cross the sheet before long.

    Most do not: they need not be followed.
    """
    normal = sheet.plane.normal_in_cam
    off_mm = points @ normal + sheet.plane.offset_mm
    with np.errstate(divide="ignore"):
        crossing_mm = -off_mm / (onward @ normal)
    return np.asarray((crossing_mm > 0.5) & (crossing_mm < _FARTHEST_MM))


def _patches(wheel: Revolution, sheet: LaserSheet) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points and normals of the polished surface, shape (S, T, 3), and its polish, (S,)."""
    strip = wheel.section(sheet.plane, sheet.source_in_cam_mm, _AROUND_MM)
    y = wheel.profile.points_mm[strip.place, 0]
    polish = np.interp(y, _PLACES_MM, _POLISH, left=0.0, right=0.0)
    chosen = np.flatnonzero(polish > 0.0)[::_EVERY]
    return strip.points_in_cam_mm[chosen], strip.normals_in_cam[chosen], polish[chosen]
