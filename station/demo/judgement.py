"""How far the station's answers are from the truth of the scenario."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, LaserSensor, pixel_grid, sheet_difference_mm
from measure import Quantity
from station.demo.scenario import RigTruth, SensorTruth
from station.documents import CalibrationDocument, RigDocument, WheelDocument

JUDGED = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR,
)
_WORKING_DEPTHS_MM = (400.0, 600.0)
_GAP_MM = 2.0


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
class RigJudgement:
    """One rig beside the truth.

    Attributes
    ----------
    places_rms_mm
        Root mean square of how far the places that pixels of all its sensors show are wrong to
        each other: what is left after moving them all as one.
    showings_used
        Showings of the target that it rests on.
    """

    rig: str
    places_rms_mm: float
    showings_used: int


@dataclass(frozen=True, slots=True)
class WheelJudgement:
    """One wheel: read and true values, mm; a value that is missing is None.

    Attributes
    ----------
    seen_mm
        The parts of the profile that each sensor gave, as stretches of d, from and to.
    """

    rig: str
    axle: int
    read: dict[str, float | None]
    u95: dict[str, float | None]
    true: dict[str, float]
    seen_mm: dict[str, list[tuple[float, float]]]
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


def judge_rig(truth: RigTruth, document: RigDocument) -> RigJudgement:
    """Hold a rig against the true one, over the fields at working distance."""
    rig, exact = document.to_rig(), truth.exact
    fields_px = {each.name: working_field_px(each.sensor) for each in exact.sensors}
    solved = np.concatenate([rig[name].locate(pixels) for name, pixels in fields_px.items()])
    true = np.concatenate([exact[name].locate(pixels) for name, pixels in fields_px.items()])
    left_mm = _moved_onto(solved, true) - true
    return RigJudgement(
        rig=truth.id,
        places_rms_mm=root_mean_square(np.linalg.norm(left_mm, axis=1)),
        showings_used=int(document.quality["showings_used"].value or 0),
    )


def _moved_onto(points_mm: FloatArray, wanted_mm: FloatArray) -> FloatArray:
    """Return points after the rigid motion that brings them nearest to others, shape (N, 3)."""
    middle, wanted_middle = points_mm.mean(axis=0), wanted_mm.mean(axis=0)
    u, _, vt = np.linalg.svd((wanted_mm - wanted_middle).T @ (points_mm - middle))
    turn = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return np.asarray((points_mm - middle) @ turn.T + wanted_middle)


def working_field_px(sensor: LaserSensor) -> FloatArray:
    """Return pixels over the part of the picture where the sheet is at working distance."""
    pixels = pixel_grid(sensor.camera.width, sensor.camera.height)
    depth = sensor.locate(pixels)[:, 2]
    at_work = (depth > _WORKING_DEPTHS_MM[0]) & (depth < _WORKING_DEPTHS_MM[1])
    return np.asarray(pixels[at_work])


def judge_wheels(truth: RigTruth, wheels: Mapping[int, WheelDocument]) -> list[WheelJudgement]:
    """Hold the wheels of a rig, by the numbers of their axles, against the true ones."""
    judged = []
    for axle, true in enumerate(truth.wheels, start=1):
        wheel = wheels.get(axle)
        readings = wheel.readings if wheel is not None else {}
        judged.append(
            WheelJudgement(
                rig=truth.id,
                axle=axle,
                read={q.value: readings[q].value if wheel else None for q in JUDGED},
                u95={q.value: readings[q].u95 if wheel else None for q in JUDGED},
                true={q.value: getattr(true.readings, q.value) for q in JUDGED},
                seen_mm=_seen_mm(wheel) if wheel is not None else {},
                reason=wheel.reason if wheel is not None else "no such wheel in the recordings",
            )
        )
    return judged


def _seen_mm(wheel: WheelDocument) -> dict[str, list[tuple[float, float]]]:
    """Return the stretches of the profile that each sensor gave."""
    profile = wheel.profile
    if profile is None or profile.seen_by is None:
        return {}
    places: Mapping[str, list[float]] = {name: [] for name in profile.sensors}
    for point, d_mm in enumerate(profile.d_mm):
        for name in profile.seen_by_names(point):
            places[name].append(d_mm)
    return {name: _stretches(np.array(d_mm)) for name, d_mm in places.items()}


def _stretches(d_mm: FloatArray) -> list[tuple[float, float]]:
    """Return the ends of runs of places, in order, without gaps."""
    if len(d_mm) == 0:
        return []
    runs = np.split(d_mm, np.flatnonzero(np.diff(d_mm) > _GAP_MM) + 1)
    return [(float(run[0]), float(run[-1])) for run in runs]


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
