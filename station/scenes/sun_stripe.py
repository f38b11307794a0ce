"""A stripe of sunlight on the wheel: the sun shines through a slit between other things."""

import math

import numpy as np

from calib import FloatArray, LightPlane
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet

_SUN_MM = 5e4
_SIGMA_MM = (0.5, 1.1)  # a slit some metres off: the sun's half degree softens its edges
_BESIDE_MM = (8.0, 30.0)


def sun_through_slit(
    wheel: Revolution, sheet: LaserSheet, rng: np.random.Generator, *, power: float
) -> LaserSheet:
    """Return the sunlight that a slit lets through, as a sheet of light beside the laser's.

    Parameters
    ----------
    wheel, sheet
        What it falls on, and the laser's sheet, which it runs beside and a little across.
    rng
        Draws where the sun and the slit are.
    power
        Its brightness over that of the laser.
    """
    side = rng.choice([-1.0, 1.0])
    ends = _two_places(wheel, sheet, side * rng.uniform(*_BESIDE_MM, 2))
    to_laser = sheet.source_in_cam_mm - ends.mean(axis=0)
    to_laser /= np.linalg.norm(to_laser)
    towards = to_laser + rng.normal(scale=0.15, size=3)
    source = ends.mean(axis=0) + _SUN_MM * towards / np.linalg.norm(towards)
    normal = np.cross(ends[0] - source, ends[1] - source)
    axis = ends.mean(axis=0) - source
    distance_mm = float(np.linalg.norm(axis))
    plane = LightPlane.from_coefficients([*normal, -float(normal @ source)])
    # So far off, the sheet's own condition on its source needs it put exactly into the plane.
    source = source - plane.distance_mm(source[None])[0] * plane.normal_in_cam
    return LaserSheet(
        plane=plane,
        source_in_cam_mm=source,
        axis_in_cam=axis / distance_mm,
        sigma_mm=rng.uniform(*_SIGMA_MM),
        # A sheet's brightness falls with the distance from its source; the sun's does not.
        power=power * distance_mm / sheet.reference_mm,
        waves=np.array([[0.0, 1.0, 2.0 * math.pi * rng.uniform()]]),
    )


def _two_places(wheel: Revolution, sheet: LaserSheet, beside_mm: FloatArray) -> FloatArray:
    """Return two points of the tread, shape (2, 3), so far beside the laser's sheet."""
    y = wheel.profile.points_mm[:, 0]
    strip = wheel.section(sheet.plane, sheet.source_in_cam_mm, beside_mm)
    tread = [int(np.argmin(np.abs(y[strip.place] - place))) for place in (-20.0, 45.0)]
    return strip.points_in_cam_mm[tread, [0, 1]]
