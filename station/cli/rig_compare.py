"""`station rig compare`: how far two calibrations of one rig differ."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from calib import FloatArray, SheetComparison, compare_placings, pixel_grid
from station.cli.output import AsJson, emit
from station.cli.verdict import Limit, hold_against
from station.documents import RigDocument
from station.errors import InputUnusable
from station.pipeline import MAP_STEP_PX


def compare(
    one: Annotated[Path, typer.Argument(metavar="A.json", help="A rig.")],
    other: Annotated[Path, typer.Argument(metavar="B.json", help="Another one of these sensors.")],
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Tell how far two rigs place what each sensor sees from each other, beside the anchor, mm."""
    first, second = RigDocument.read(one), RigDocument.read(other)
    compared = _compared(first, second)
    data = {
        "anchor": first.anchor,
        "sensors": {name: _data(found) for name, found in compared.items()},
    }
    lines = [_compared_text(name, first.anchor, found) for name, found in compared.items()]
    emit(data, "\n".join(lines), as_json=as_json)
    for name, found in compared.items():
        hold_against(limit, found.rms_mm, f"RMS difference of {name}")


def _compared(first: RigDocument, second: RigDocument) -> dict[str, SheetComparison]:
    if first.anchor not in second.names:
        raise InputUnusable(
            f"the anchor {first.anchor} is no sensor of the other rig, which has "
            f"{', '.join(second.names)}; give two rigs of the same sensors"
        )
    common = [name for name in first.names if name in second.names and name != first.anchor]
    if not common:
        raise InputUnusable(
            f"the rigs have no sensor but {first.anchor} in common; give two of the same sensors"
        )
    one, other = first.to_rig(), second.to_rig()
    return {
        name: compare_placings(
            one,
            other,
            sensor=name,
            anchor=first.anchor,
            pixels_px=_working_pixels(name, first, second),
        )
        for name in common
    }


def _working_pixels(name: str, *documents: RigDocument) -> FloatArray:
    """Return pixels whose point on the sheet lies no nearer or farther than stripes did."""
    sensor = documents[0].to_rig()[name].sensor
    pixels = pixel_grid(sensor.camera.width, sensor.camera.height, MAP_STEP_PX)
    known = [
        each.depths_mm
        for document in documents
        for each in document.sensors
        if each.sensor == name and each.depths_mm is not None
    ]
    if not known:
        return pixels
    depth = sensor.locate(pixels)[:, 2]
    nearest, farthest = min(low for low, _ in known), max(high for _, high in known)
    inside = (depth >= nearest) & (depth <= farthest)
    return pixels[inside] if inside.any() else pixels


def _data(found: SheetComparison) -> dict[str, Any]:
    return {
        "rms_mm": found.rms_mm,
        "largest_mm": float(np.nanmax(found.difference_mm)),
        "expected_mm": found.expected_mm,
        "agree": found.agree,
    }


def _compared_text(name: str, anchor: str, found: SheetComparison) -> str:
    verdict = "agree within their uncertainties"
    if not found.agree:
        verdict = "differ by more than their uncertainties explain"
    return (
        f"{name} beside {anchor}: RMS {found.rms_mm:.4f} mm, largest "
        f"{np.nanmax(found.difference_mm):.4f} mm; both uncertainties together expect "
        f"{found.expected_mm:.4f} mm RMS: they {verdict}"
    )
