"""`station compare`: how far two calibrations differ over the working volume."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from calib import FloatArray, SheetComparison, compare_sensors
from station.cli.output import AsJson, emit
from station.cli.verdict import Limit, hold_against
from station.documents import CalibrationDocument
from station.errors import NothingMeasurable
from station.pipeline import MAP_STEP_PX, working_pixels


def compare(
    one: Annotated[Path, typer.Argument(metavar="A.json", help="A calibration.")],
    other: Annotated[Path, typer.Argument(metavar="B.json", help="Another one of this camera.")],
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Tell how far two calibrations differ over the working volume, mm."""
    documents = [CalibrationDocument.read(path) for path in (one, other)]
    first, second = (document.laser_sensor() for document in documents)
    comparison = compare_sensors(first, second, working_pixels(documents))
    if not np.isfinite(comparison.difference_mm).any():
        raise NothingMeasurable(
            f"{one} and {other} see no part of the sheet in common; are they of one sensor?"
        )
    verdict = _verdict(comparison)
    emit(_data(comparison, verdict), _text(comparison, verdict), as_json=as_json)
    hold_against(limit, comparison.rms_mm, "RMS difference")


def _verdict(comparison: SheetComparison) -> str:
    if comparison.agree:
        return "they agree within their uncertainties"
    return "they differ by more than their uncertainties explain"


def _text(comparison: SheetComparison, verdict: str) -> str:
    u, v = comparison.pixels_px[comparison.worst]
    return (
        f"RMS {comparison.rms_mm:.4f} mm, largest {np.nanmax(comparison.difference_mm):.4f} mm at "
        f"pixel ({u:.0f}, {v:.0f}); both uncertainties together expect "
        f"{comparison.expected_mm:.4f} mm RMS\n{verdict}"
    )


def _data(comparison: SheetComparison, verdict: str) -> dict[str, Any]:
    u, v = comparison.pixels_px[comparison.worst].tolist()
    return {
        "rms_mm": comparison.rms_mm,
        "largest_mm": float(np.nanmax(comparison.difference_mm)),
        "largest_at_px": {"u": u, "v": v},
        "expected_mm": comparison.expected_mm,
        "agree": comparison.agree,
        "verdict": verdict,
        "map": _map(comparison),
    }


def _map(comparison: SheetComparison) -> dict[str, Any]:
    """Lay the field out as a grid, null where a pixel is not in it."""
    u, column = np.unique(comparison.pixels_px[:, 0], return_inverse=True)
    v, row = np.unique(comparison.pixels_px[:, 1], return_inverse=True)

    def grid(values: FloatArray) -> list[list[float | None]]:
        cells: list[list[float | None]] = [[None] * len(u) for _ in v]
        for place, value in enumerate(values):
            if np.isfinite(value):
                cells[row[place]][column[place]] = round(float(value), 6)
        return cells

    return {
        "step_px": MAP_STEP_PX,
        "u_px": u.tolist(),
        "v_px": v.tolist(),
        "difference_mm": grid(comparison.difference_mm),
        "sigma_mm": grid(comparison.sigma_mm),
    }
