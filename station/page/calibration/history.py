"""How a sensor has drifted: its calibrations over time, each beside the one before."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from station.documents import CalibrationDocument
from station.store import Activation, Calibration, CalibrationState, Recalibration, active
from station.store.lists import activations_page, recalibrations_page
from station.store.recalibrations import reasons_for

_U95 = 1.96
_MOST = 200
_NIGHTS = 30


@dataclass(frozen=True, slots=True)
class Reading:
    """A figure of a calibration with its expanded uncertainty (95 %)."""

    value: float
    u95: float


@dataclass(frozen=True, slots=True)
class DriftPoint:
    """What a calibration says of the sensor.

    Attributes
    ----------
    angle_deg
        Of the sheet to the optical axis.
    offset_mm
        Of the sheet from the camera.
    mid_mm
        Distance of the sheet along the ray of the middle of the picture: what a wheel there is
        moved by.
    activated
        Whether it ever came into force.
    """

    calibration: str
    at: datetime
    angle_deg: Reading
    offset_mm: Reading
    mid_mm: Reading | None
    dots_px: float
    stripe_px: float
    activated: bool


@dataclass(frozen=True, slots=True)
class History:
    """A sensor's past."""

    sensor: str
    present: str | None
    points: tuple[DriftPoint, ...]
    activations: tuple[tuple[Activation, Recalibration | None], ...]
    nights: tuple[Recalibration, ...]


def history_of(session: Session, sensor: str) -> History:
    """Return a sensor's calibrations from the oldest on, what came into force, and its nights."""
    page = activations_page(session, sensor, limit=_MOST)
    why = reasons_for(session, page.rows)
    ever = {each.calibration_id for each in page.rows}
    rows = session.scalars(
        select(Calibration)
        .where(Calibration.sensor == sensor)
        .where(Calibration.state == CalibrationState.READY)
        .order_by(Calibration.created_at.desc())
        .limit(_MOST)
    ).all()
    present = active(session, sensor)
    return History(
        sensor=sensor,
        present=None if present is None else present.calibration_id,
        points=tuple(_points(reversed(rows), ever)),
        activations=tuple((each, why[each.version][1]) for each in page.rows),
        nights=tuple(recalibrations_page(session, sensor, limit=_NIGHTS).rows),
    )


def _points(rows: Iterable[Calibration], ever: set[str]) -> Iterable[DriftPoint]:
    for row in rows:
        document = CalibrationDocument.model_validate_json(row.document or "")
        yield drift_point(row.id, row.created_at, document, activated=row.id in ever)


def drift_point(
    calibration: str, at: datetime, document: CalibrationDocument, *, activated: bool
) -> DriftPoint:
    """Return what a calibration says of the sensor."""
    plane, covariance = document.plane, np.array(document.plane_covariance)
    sine = min(abs(plane.c), 1.0)
    # d(asin c)/dc grows without bound where the sheet stands square to the axis.
    slope = 1.0 / max(math.sqrt(1.0 - sine**2), 1e-6)
    return DriftPoint(
        calibration=calibration,
        at=at,
        angle_deg=Reading(
            math.degrees(math.asin(sine)),
            _U95 * math.degrees(slope * math.sqrt(max(covariance[2, 2], 0.0))),
        ),
        offset_mm=Reading(plane.d, _U95 * math.sqrt(max(covariance[3, 3], 0.0))),
        mid_mm=_mid(document),
        dots_px=document.rms.dots_px,
        stripe_px=document.rms.stripe_px,
        activated=activated,
    )


def drift_of(history: History) -> dict[str, Any]:
    """Return the columns that the charts of a sensor are drawn of."""
    points = history.points

    def column(readings: Iterable[Reading | None]) -> dict[str, list[float | None]]:
        told = list(readings)
        return {
            "values": [None if each is None else each.value for each in told],
            "u95": [None if each is None else each.u95 for each in told],
        }

    return {
        "at_s": [each.at.timestamp() for each in points],
        "calibrations": [each.calibration for each in points],
        "mid_mm": column(each.mid_mm for each in points),
        "angle_deg": column(each.angle_deg for each in points),
        "offset_mm": column(each.offset_mm for each in points),
        "dots_px": [each.dots_px for each in points],
        "stripe_px": [each.stripe_px for each in points],
        "in_force": [
            {"at_s": row.activated_at.timestamp(), "calibration": row.calibration_id}
            for row, _ in history.activations
        ],
    }


def _mid(document: CalibrationDocument) -> Reading | None:
    sensor = document.laser_sensor()
    middle_px = np.array([[(sensor.camera.width - 1) / 2.0, (sensor.camera.height - 1) / 2.0]])
    point = sensor.locate(middle_px)[0]
    distance_mm = float(np.linalg.norm(point))
    if not math.isfinite(distance_mm):
        return None
    along = point / distance_mm
    variance = float(along @ sensor.location_covariance(middle_px)[0] @ along)
    return Reading(distance_mm, _U95 * math.sqrt(max(variance, 0.0)))
