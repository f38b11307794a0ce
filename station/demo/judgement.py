"""How far the station's answers are from the truth of the scenario."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, LaserSensor, pixel_grid, sheet_difference_mm
from measure import Quantity
from station.demo.scenario import SensorTruth
from station.documents import CalibrationDocument, WheelDocument

JUDGED = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR,
)
_WORKING_DEPTHS_MM = (400.0, 600.0)


@dataclass(frozen=True, slots=True)
class PlaneJudgement:
    """One calibration beside the truth.

    Attributes
    ----------
    plane_rms_mm
        Root mean square, over the field, of the true sheet's distance from the solved plane.
    sheet_rms_mm
        The same of how far pixels are placed wrongly: plane and camera together.
    normal_error_deg, offset_error_mm
        Angle of the normals, difference of d.
    """

    sensor: str
    method: str
    plane_rms_mm: float
    sheet_rms_mm: float
    normal_error_deg: float
    offset_error_mm: float
    pictures_used: int


@dataclass(frozen=True, slots=True)
class WheelJudgement:
    """One wheel: read and true values, mm; a value that is missing is None."""

    sensor: str
    axle: int
    method: str
    read: dict[str, float | None]
    u95: dict[str, float | None]
    true: dict[str, float]
    reason: str | None


def judge_plane(truth: SensorTruth, document: CalibrationDocument) -> PlaneJudgement:
    """Hold a calibration against the true sensor, over the field at working distance."""
    solved, true = document.laser_sensor(), truth.sensor
    field_px = working_field_px(true)
    cosine = float(solved.plane.normal_in_cam @ true.plane.normal_in_cam)
    return PlaneJudgement(
        sensor=truth.id,
        method=document.method,
        plane_rms_mm=root_mean_square(solved.plane.distance_mm(true.locate(field_px))),
        sheet_rms_mm=root_mean_square(sheet_difference_mm(solved, true, field_px)),
        normal_error_deg=math.degrees(math.acos(min(1.0, cosine))),
        offset_error_mm=solved.plane.offset_mm - true.plane.offset_mm,
        pictures_used=len(document.poses),
    )


def working_field_px(sensor: LaserSensor) -> FloatArray:
    """Return pixels over the part of the picture where the sheet is at working distance."""
    pixels = pixel_grid(sensor.camera.width, sensor.camera.height)
    depth = sensor.locate(pixels)[:, 2]
    at_work = (depth > _WORKING_DEPTHS_MM[0]) & (depth < _WORKING_DEPTHS_MM[1])
    return np.asarray(pixels[at_work])


def judge_wheels(
    truth: SensorTruth, method: str, wheels: Sequence[WheelDocument]
) -> list[WheelJudgement]:
    """Hold the wheels of a sensor, in the order they came by, against the true ones."""
    judged = []
    for axle, true in enumerate(truth.wheels):
        wheel = wheels[axle] if axle < len(wheels) else None
        readings = wheel.readings if wheel is not None else {}
        judged.append(
            WheelJudgement(
                sensor=truth.id,
                axle=axle + 1,
                method=method,
                read={q.value: readings[q].value if wheel else None for q in JUDGED},
                u95={q.value: readings[q].u95 if wheel else None for q in JUDGED},
                true={q.value: getattr(true.readings, q.value) for q in JUDGED},
                reason=wheel.reason if wheel is not None else "no such wheel in the recording",
            )
        )
    return judged


def reading_rms_mm(wheels: Iterable[WheelJudgement], quantity: str) -> float | None:
    """Root mean square error of a quantity over wheels; None where one of them is missing."""
    errors = []
    for wheel in wheels:
        value = wheel.read[quantity]
        if value is None:
            return None
        errors.append(value - wheel.true[quantity])
    return root_mean_square(np.array(errors)) if errors else None


def root_mean_square(values: FloatArray) -> float:
    """Root mean square of finite values."""
    return float(np.sqrt(np.mean(np.square(values[np.isfinite(values)]))))
