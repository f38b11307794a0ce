"""`station evaluate`: how good a calibration is, told by things whose size is known."""

from typing import Any

import numpy as np
import typer

from calib import FloatArray, PlacementDistances, Target
from station.cli.evaluate_again import leave_one_out, repeatability
from station.cli.evaluate_cylinder import cylinder
from station.cli.evaluate_piece import piece, step
from station.cli.options import CalibrationPath, Sources, TargetText
from station.cli.output import AsJson, emit, progress_bar
from station.cli.verdict import Limit, hold_against, rounded
from station.documents import CalibrationDocument
from station.errors import NothingMeasurable
from station.pipeline import distances_of_sources

app = typer.Typer(
    help="How good a calibration is, told by things whose size is known.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command("cylinder")(cylinder)
app.command("piece")(piece)
app.command("step")(step)
app.command("repeatability")(repeatability)
app.command("leave-one-out")(leave_one_out)


@app.command()
def distances(
    sources: Sources,
    target: TargetText,
    calibration: CalibrationPath,
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Measure distances between crossings of the stripe with the grid of a target."""
    sensor = CalibrationDocument.read(calibration).laser_sensor()
    with progress_bar("distances") as progress:
        placements, left_out = distances_of_sources(
            sources, Target.parse(target), sensor, progress=progress
        )
    measured = [placement for placement in placements if not placement.reason]
    unmeasured = {
        **dict(left_out),
        **{placement.name: placement.reason for placement in placements if placement.reason},
    }
    if not measured:
        first = next(iter(unmeasured.items()), ("no picture", "nothing in the sources"))
        raise NothingMeasurable(f"no distance could be measured; {first[0]}: {first[1]}")
    errors = np.concatenate([placement.errors_mm for placement in measured])
    rms, worst = _rms(errors), float(np.abs(errors).max())
    data = {
        "rms_mm": rms,
        "largest_mm": worst,
        "distances": len(errors),
        "placements": [_distances_data(placement) for placement in measured],
        "left_out": unmeasured,
        "limit_mm": limit,
    }
    lines = [
        f"{p.name}: {len(p.errors_mm)} distances over {p.lines}, RMS {_rms(p.errors_mm):.4f} mm"
        for p in measured
    ]
    lines += [f"left out {name}: {reason}" for name, reason in unmeasured.items()]
    lines.append(f"RMS {rms:.4f} mm, largest {worst:.4f} mm, {len(errors)} distances")
    emit(data, "\n".join(lines), as_json=as_json)
    hold_against(limit, rms, "RMS of the distances")


def _distances_data(placement: PlacementDistances) -> dict[str, Any]:
    return {
        "name": placement.name,
        "crossed": placement.lines,
        "rms_mm": _rms(placement.errors_mm),
        "measured_mm": rounded(placement.measured_mm),
        "gauged_mm": rounded(placement.gauged_mm),
    }


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
