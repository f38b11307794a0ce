"""`station table`: the sheet as a lookup table, for those who measure elsewhere."""

import io
import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from calib import LightPlane, SheetTable
from station.cli.output import AsJson, emit
from station.documents import CalibrationDocument, write_whole
from station.errors import InputUnusable

_MEANING = {
    "u_px": "columns of the table: pixel coordinate u; (0, 0) is the top-left pixel's centre",
    "v_px": "rows of the table: pixel coordinate v",
    "sheet_mm": "(row, column, 2): (s, t) on the sheet, mm; NaN where a pixel sees no sheet",
    "in_cam_mm": "(row, column, 3): the same point in the camera frame (x right, y down, z ahead)",
    "sigma_mm": "(row, column): standard deviation along the worst direction, by the calibration",
    "origin_in_cam_mm": "camera frame: point = origin_in_cam_mm + s axes_in_cam[0] + t "
    "axes_in_cam[1]; the foot of the perpendicular from the camera's centre",
    "axes_in_cam": "(2, 3): unit directions of s (the camera's x seen along the normal) and t",
    "plane": "a, b, c, d: a x + b y + c z + d = 0, camera frame, mm",
    "metadata": "this text: JSON",
}


def table(
    calibration: Annotated[Path, typer.Argument(metavar="calibration.json", help="A calibration.")],
    out: Annotated[Path, typer.Option(metavar="FILE.npz", help="NumPy archive to write.")],
    step: Annotated[int, typer.Option(min=1, metavar="PX", help="Every how many pixels.")] = 8,
    as_json: AsJson = False,
) -> None:
    """Export the sheet: for pixels, the point on it in mm, with its standard deviation."""
    document = CalibrationDocument.read(calibration)
    sensor = document.laser_sensor()
    if out.suffix != ".npz":
        raise InputUnusable(f"--out {out}; allowed: a name that ends in .npz")
    sheet = SheetTable.of(sensor, step)
    located = np.isfinite(sheet.sigma_mm)
    if not located.any():
        raise InputUnusable(f"{calibration}: no pixel of its picture sees the sheet")
    metadata = {
        "format": "treadline-sheet-table",
        "version": 1,
        "sensor": document.sensor,
        "calibration": document.fingerprint,
        "created": document.created.isoformat(),
        "width": sensor.camera.width,
        "height": sensor.camera.height,
        "step_px": step,
        "arrays": _MEANING,
    }
    write_whole(out, _archive(sheet, sensor.plane, metadata))
    data = {
        "out": str(out),
        "rows": len(sheet.v_px),
        "columns": len(sheet.u_px),
        "located": int(located.sum()),
        "sigma_mm": {
            "median": float(np.median(sheet.sigma_mm[located])),
            "largest": float(sheet.sigma_mm[located].max()),
        },
    }
    text = (
        f"{len(sheet.v_px)} x {len(sheet.u_px)} pixels, {located.mean():.0%} of them on the sheet, "
        f"sigma {np.median(sheet.sigma_mm[located]):.4f} mm in the median\nwritten to {out}"
    )
    emit(data, text, as_json=as_json)


def _archive(sheet: SheetTable, plane: LightPlane, metadata: dict[str, Any]) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(
        stream,
        u_px=sheet.u_px,
        v_px=sheet.v_px,
        sheet_mm=sheet.sheet_mm,
        in_cam_mm=sheet.in_cam_mm,
        sigma_mm=sheet.sigma_mm,
        origin_in_cam_mm=sheet.frame.origin_in_cam_mm,
        axes_in_cam=sheet.frame.axes_in_cam,
        plane=plane.coefficients,
        metadata=np.array(json.dumps(metadata, indent=1)),
    )
    return stream.getvalue()
