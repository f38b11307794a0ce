"""From calibration files to the figures a decision rests on."""

from collections.abc import Callable
from datetime import datetime

import numpy as np

from calib import (
    CameraMismatch,
    FloatArray,
    LaserSensor,
    SheetComparison,
    compare_sensors,
    compare_sheets,
    compare_update,
)
from station.documents import CalibrationDocument
from station.pipeline import working_pixels
from station.recalibration import Difference, NewCalibration

_NOWHERE = float("nan")
_Compare = Callable[[LaserSensor, LaserSensor, FloatArray], SheetComparison]


def sheet_difference(present: CalibrationDocument, new: CalibrationDocument) -> Difference:
    """Return how far the sheet has moved, seen through the camera of the calibration in force."""
    return _difference(present, new, compare_sheets)


def whole_difference(
    present: CalibrationDocument, new: CalibrationDocument, *, camera_kept: bool
) -> Difference:
    """Return how far two calibrations differ, the cameras included.

    `camera_kept` says that the new one was solved with the camera of the other as its prior;
    without, they count as independent.
    """
    return _difference(present, new, compare_update if camera_kept else compare_sensors)


def _difference(
    present: CalibrationDocument, new: CalibrationDocument, compare: _Compare
) -> Difference:
    pixels = working_pixels([present, new])
    one, other = present.laser_sensor(), new.laser_sensor()
    sigmas = (_sheet_sigma_mm(one, pixels), _sheet_sigma_mm(other, pixels))
    try:
        found = compare(one, other, pixels)
    except CameraMismatch:
        return Difference(_NOWHERE, _NOWHERE, (_NOWHERE, _NOWHERE), _NOWHERE, *sigmas)
    if not np.isfinite(found.difference_mm).any():
        return Difference(_NOWHERE, _NOWHERE, (_NOWHERE, _NOWHERE), _NOWHERE, *sigmas)
    u, v = found.pixels_px[found.worst].tolist()
    return Difference(
        rms_mm=found.rms_mm,
        largest_mm=float(np.nanmax(found.difference_mm)),
        largest_at_px=(u, v),
        expected_mm=found.expected_mm,
        present_sigma_mm=sigmas[0],
        new_sigma_mm=sigmas[1],
    )


def _sheet_sigma_mm(sensor: LaserSensor, pixels_px: FloatArray) -> float:
    variance = np.trace(sensor.location_covariance(pixels_px), axis1=1, axis2=2)
    finite = variance[np.isfinite(variance)]
    return float(np.sqrt(finite.mean())) if len(finite) else _NOWHERE


def soundness_of(
    new: CalibrationDocument, *, pictures_at: datetime, now: datetime
) -> NewCalibration:
    """Return how good a new calibration is by itself.

    Parameters
    ----------
    pictures_at
        When the oldest of its pictures were taken.
    now
        The present moment.
    """
    return NewCalibration(
        poses=len(new.poses),
        rms_dots_px=new.rms.dots_px,
        rms_stripe_px=new.rms.stripe_px,
        pictures_age_h=(now - pictures_at).total_seconds() / 3600.0,
        failed_gates=tuple(name for name, gate in new.quality.items() if not gate.passed),
    )
