"""What the drawings of a sensor's report are made of, as JSON: pictures, maps over the field."""

from typing import Any

import numpy as np

from calib import CalibError, FloatArray, LaserSensor, compare_sensors, compare_sheets, pixel_grid
from station.documents import CalibrationDocument
from station.page.calibration.pictures import pictures_drawn, rms, told
from station.pipeline import working_pixels
from station.report import evidence_of

_CELLS_ACROSS = 48
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
    step_px = max(document.camera.width // _CELLS_ACROSS, 1)
    return {
        **pictures_drawn(document, evidence_of(points_csv), size_of(document)),
        "sheet": _map(document, step_px),
        "comparison": None if present is None else comparison_of(document, present, step_px),
    }


def size_of(document: CalibrationDocument) -> tuple[int, int]:
    """Return the size of the pictures, px."""
    return document.camera.width, document.camera.height


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
        "rms_mm": told(whole.rms_mm),
        "expected_mm": told(whole.expected_mm),
        "largest_mm": told(float(np.nanmax(whole.difference_mm))),
        "largest_at_px": [u, v],
        "agree": whole.agree,
        "sheet_rms_mm": told(sheets.rms_mm),
        "sheet_expected_mm": told(sheets.expected_mm),
        "map": _cells(compare_sensors(one, other, grid_px).difference_mm, one, step_px),
    }


def _map(document: CalibrationDocument, step_px: int) -> _Json:
    sensor = document.laser_sensor()
    cells = _cells(sensor.sigma_on_sheet(_grid(sensor, step_px)), sensor, step_px)
    working = sensor.sigma_on_sheet(working_pixels([document]))
    return {**cells, "rms_mm": told(rms(working[np.isfinite(working)]))}


def _grid(sensor: LaserSensor, step_px: int) -> FloatArray:
    return pixel_grid(sensor.camera.width, sensor.camera.height, step_px)


def _cells(values_mm: FloatArray, sensor: LaserSensor, step_px: int) -> _Json:
    """Return a map: values in rows of so many columns, null where there is no sheet."""
    columns = len(np.arange(step_px / 2 - 0.5, sensor.camera.width, step_px))
    rounded = [told(value, 5) for value in values_mm.tolist()]
    return {"step_px": step_px, "columns": columns, "values_mm": rounded}
