"""What the drawings of a report are made of, as JSON: pictures, residuals, maps over the field."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from calib import CalibError, FloatArray, LaserSensor, compare_sensors, compare_sheets, pixel_grid
from station.documents import CalibrationDocument
from station.operations import FramePlace
from station.pipeline import working_pixels
from station.report import (
    PictureEvidence,
    PointSet,
    RankedPicture,
    evidence_of,
    whitened_dots,
    whitened_stripe,
    worst_first,
)

_MOST_STRIPE_POINTS = 150
_MOST_NEEDLES = 1500
_CELLS_ACROSS = 48
_REACH_SIGMA, _BINS = 4.0, 32
_Json = dict[str, Any]


def figures_of(
    document: CalibrationDocument, points_csv: str, present: CalibrationDocument | None
) -> _Json:
    """Return what is drawn of a calibration as a whole.

    Parameters
    ----------
    present
        What is in force instead; None where nothing is, or this one.
    """
    pictures = evidence_of(points_csv)
    ranked = worst_first(document, pictures)
    step_px = max(document.camera.width // _CELLS_ACROSS, 1)
    return {
        "size_px": [document.camera.width, document.camera.height],
        "pictures": [_summary(each) for each in ranked],
        "field": {
            "dots": _needles([each.dots for each in pictures]),
            "stripe": _needles([each.stripe for each in pictures]),
        },
        "histograms": {
            "dots": _histogram(whitened_dots(pictures)),
            "stripe": _histogram(whitened_stripe(pictures)),
        },
        "sheet": _map(document, step_px),
        "comparison": None if present is None else comparison_of(document, present, step_px),
    }


def picture_of(
    document: CalibrationDocument,
    points_csv: str,
    place: int,
    frames: Mapping[str, FramePlace],
) -> _Json | None:
    """Return one picture's points, by its place in the ranking; None where there is none."""
    ranked = worst_first(document, evidence_of(points_csv))
    if not 0 <= place < len(ranked):
        return None
    evidence = ranked[place].evidence
    frame = frames.get(evidence.name)
    return {
        **_summary(ranked[place]),
        "frame": None if frame is None else {"recording": frame.recording, "number": frame.number},
        "size_px": [document.camera.width, document.camera.height],
        "dots": _points(evidence.dots, 1),
        "stripe": _points(evidence.stripe, -(-len(evidence.stripe) // _MOST_STRIPE_POINTS) or 1),
    }


def comparison_of(
    document: CalibrationDocument, present: CalibrationDocument, step_px: int
) -> _Json:
    """Return how far two calibrations of one sensor differ, over the whole and over the field."""
    one, other = present.laser_sensor(), document.laser_sensor()
    field_px = working_pixels([present, document])
    try:
        whole = compare_sensors(one, other, field_px)
        sheets = compare_sheets(one, other, field_px)
    except CalibError as error:
        return {"why_not": str(error)}
    if not np.isfinite(whole.difference_mm).any():
        return {"why_not": "no pixel sees both sheets"}
    u, v = whole.pixels_px[whole.worst].tolist()
    grid_px = _grid(one, step_px)
    return {
        "rms_mm": _told(whole.rms_mm),
        "expected_mm": _told(whole.expected_mm),
        "largest_mm": _told(float(np.nanmax(whole.difference_mm))),
        "largest_at_px": [u, v],
        "agree": whole.agree,
        "sheet_rms_mm": _told(sheets.rms_mm),
        "sheet_expected_mm": _told(sheets.expected_mm),
        "map": _cells(compare_sensors(one, other, grid_px).difference_mm, one, step_px),
    }


def _summary(ranked: RankedPicture) -> _Json:
    evidence = ranked.evidence
    return {
        "name": evidence.name,
        "left_out": ranked.left_out,
        "warnings": list(ranked.warnings),
        "distance_mm": _told(ranked.distance_mm),
        "tilt_deg": _told(ranked.tilt_deg),
        "dots_used": int(evidence.dots.used.sum()),
        "dots_of": len(evidence.dots),
        "dots_rms_px": _told(evidence.dots.rms_px),
        "stripe_used": int(evidence.stripe.used.sum()),
        "stripe_of": len(evidence.stripe),
        "stripe_rms_px": _told(evidence.stripe.rms_px),
        "unused": _unused(evidence),
    }


def _unused(evidence: PictureEvidence) -> list[list[Any]]:
    kinds = (("dots", evidence.dots), ("stripe", evidence.stripe))
    return [
        [kind, reason, count]
        for kind, points in kinds
        for reason, count in points.unused_by_reason.most_common()
    ]


def _points(points: PointSet, every: int) -> _Json:
    known = np.asarray(np.isfinite(points.corrected_px).all(axis=1))
    return {
        "seen_px": np.round(points.seen_px[::every], 3).tolist(),
        "corrected_px": [
            pair if told else None
            for pair, told in zip(
                np.round(points.corrected_px[::every], 3).tolist(),
                known[::every].tolist(),
                strict=True,
            )
        ],
        "used": points.used[::every].tolist(),
        "reason": list(points.reason[::every]),
    }


def _needles(sets: Sequence[PointSet]) -> _Json:
    """Return places and deviations of the points used, every n-th of many."""
    none = np.empty((0, 2))
    places = np.vstack([none, *(points.seen_px[points.used] for points in sets)])
    deviations = np.vstack([none, *(points.deviation_px[points.used] for points in sets)])
    every = -(-len(places) // _MOST_NEEDLES) or 1
    return {
        "every": every,
        "rms_px": _told(_rms(np.linalg.norm(deviations, axis=1))),
        "at_px": np.round(places[::every]).astype(int).tolist(),
        "by_px": np.round(deviations[::every], 3).tolist(),
    }


def _histogram(whitened: FloatArray) -> _Json:
    counts, edges = np.histogram(whitened, bins=_BINS, range=(-_REACH_SIGMA, _REACH_SIGMA))
    return {
        "counts": counts.tolist(),
        "edges": edges.tolist(),
        "points": int(whitened.size),
        "beyond": int(whitened.size - counts.sum()),
        "rms": _told(_rms(whitened)),
    }


def _map(document: CalibrationDocument, step_px: int) -> _Json:
    sensor = document.laser_sensor()
    cells = _cells(sensor.sigma_on_sheet(_grid(sensor, step_px)), sensor, step_px)
    working = sensor.sigma_on_sheet(working_pixels([document]))
    return {**cells, "rms_mm": _told(_rms(working[np.isfinite(working)]))}


def _grid(sensor: LaserSensor, step_px: int) -> FloatArray:
    return pixel_grid(sensor.camera.width, sensor.camera.height, step_px)


def _cells(values_mm: FloatArray, sensor: LaserSensor, step_px: int) -> _Json:
    """Return a map: values in rows of so many columns, null where there is no sheet."""
    columns = len(np.arange(step_px / 2 - 0.5, sensor.camera.width, step_px))
    rounded = [_told(value, 5) for value in values_mm.tolist()]
    return {"step_px": step_px, "columns": columns, "values_mm": rounded}


def _told(value: float, digits: int = 6) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
