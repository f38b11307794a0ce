"""Sensors whose sheet is no longer where their calibration found it: freed, and told."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.camera import PARAMETERS
from calib.sensor import LaserSensor
from calib.solving.joint.parameters import tangent_basis
from calib.solving.rig.seen import SeenView
from calib.solving.rig.sheets import points_on_sheets

# Most lines of a sensor lie so many standard deviations off its sheet, and it was bent since.
_BENT = 3.5
# What a line's place on a board is known to beside all else: the board's own errors.
_LEAST_SIGMA_MM = 0.05
# What is then known of the sheet: enough for pictures to tell the rest.
_OPEN_RAD, _OPEN_MM = 0.1, 20.0
_FEWEST_STRIPES = 3


def without_bent_sheets(
    views: Sequence[SeenView], sensors: Mapping[str, LaserSensor]
) -> tuple[dict[str, LaserSensor], tuple[str, ...]]:
    """Return the sensors, those that were bent with an open sheet, and what to say of these.

    Held against a sheet that moved, true stripes would pull the poses off the dots, or be taken
    for false as a whole.
    """
    on_sheet = points_on_sheets(views)
    found, warnings = dict(sensors), []
    for name, sensor in sensors.items():
        off_mm, sigma_mm = _off_sheet(views, name, sensor, on_sheet)
        held = not sensor.covariance[len(PARAMETERS) :].any()
        if held or len(off_mm) < _FEWEST_STRIPES or np.median(off_mm / sigma_mm) <= _BENT:
            continue
        found[name] = _opened(sensor)
        warnings.append(
            f"the sheet of {name!r} lies {np.median(off_mm):.2g} mm off where its calibration has "
            "it, and was solved from these pictures alone; calibrate the sensor anew"
        )
    return found, tuple(warnings)


def _off_sheet(
    views: Sequence[SeenView],
    name: str,
    sensor: LaserSensor,
    on_sheet: Mapping[tuple[str, str], BoolArray],
) -> tuple[FloatArray, FloatArray]:
    """Return how far the lines of a sensor lie off its sheet, and one sigma of it, shapes (N,)."""
    off_mm, sigma_mm = [], []
    known = sensor.covariance[len(PARAMETERS) :, len(PARAMETERS) :]
    for view in views:
        if view.sensor != name or view.line is None or not on_sheet[view.showing, name].any():
            continue
        middle = np.append(view.line.ends_mm.mean(axis=0), 1.0)
        off_mm.append(abs(float(sensor.plane.coefficients @ middle)))
        variance = middle @ known @ middle + view.sigma_mm**2 + _LEAST_SIGMA_MM**2
        sigma_mm.append(float(np.sqrt(variance)))
    return np.array(off_mm), np.array(sigma_mm)


def _opened(sensor: LaserSensor) -> LaserSensor:
    covariance = sensor.covariance.copy()
    basis = tangent_basis(sensor.plane.normal_in_cam)
    plane = covariance[len(PARAMETERS) :, len(PARAMETERS) :]
    plane[:3, :3] += _OPEN_RAD**2 * basis @ basis.T
    plane[3, 3] += _OPEN_MM**2
    return replace(sensor, covariance=covariance)
