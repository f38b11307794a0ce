"""What every gauge truly reads on a wheel whose outline is known, by the gauges' definitions."""

from collections.abc import Iterable

import numpy as np

from calib import FloatArray
from measure import Quantity, WheelReadings, reference_profile
from station.scenes import WheelTruth

# Where `measure` looks for the greatest wear and for a hollow, y.
_TREAD_Y_MM = (-14.0, 48.0)
_HOLLOW_Y_MM = (-14.0, 56.0)


def true_values(wheel: WheelTruth) -> dict[Quantity, float]:
    """Return what every gauge truly reads on a wheel, off its dense outline, mm."""
    read = wheel.readings
    return {
        Quantity.FLANGE_HEIGHT: read.flange_height,
        Quantity.FLANGE_THICKNESS_10: read.flange_thickness_10,
        Quantity.FLANGE_THICKNESS_12: read.flange_thickness_12,
        Quantity.FLANGE_GRADIENT_QR: read.flange_gradient_qr,
        Quantity.TREAD_WEAR: read.tread_wear,
        Quantity.TREAD_WEAR_AT_70: read.tread_wear,
        Quantity.TREAD_WEAR_MAX: _greatest_wear_mm(wheel),
        Quantity.HOLLOW_DEPTH: _hollow_mm(wheel),
    }


def errors_and_u95(
    answer: WheelReadings, wheel: WheelTruth, quantities: Iterable[Quantity]
) -> list[tuple[float, float]]:
    """Return how far each reading is off and its u95, mm; NaN where it is not given."""
    truth = true_values(wheel)
    readings = ((quantity, answer.readings[quantity]) for quantity in quantities)
    return [
        (float("nan"), float("nan"))
        if reading.value is None or reading.u95 is None
        else (reading.value - truth[quantity], reading.u95)
        for quantity, reading in readings
    ]


def _greatest_wear_mm(wheel: WheelTruth) -> float:
    y, z = _between(wheel, *_TREAD_Y_MM)
    reference = reference_profile(wheel.reference)
    tip = wheel.profile.points_mm[:, 1].max()
    below = reference.height_mm(y) - reference.nominal[Quantity.FLANGE_HEIGHT] - (z - tip)
    return float(below.max())


def _hollow_mm(wheel: WheelTruth) -> float:
    _, z = _between(wheel, *_HOLLOW_Y_MM)
    return float(np.max(z - np.minimum.accumulate(z)))


def _between(wheel: WheelTruth, low_mm: float, high_mm: float) -> FloatArray:
    points = wheel.profile.points_mm
    inside = (points[:, 0] >= low_mm) & (points[:, 0] <= high_mm)
    return np.asarray(points[inside].T)
