"""`station evaluate`: how good a calibration is, told by things whose size is known."""

from typing import Annotated, Any

import numpy as np
import typer

from calib import CylinderReading, FloatArray, PlacementDistances, Target
from station.cli.evaluate_again import leave_one_out, repeatability
from station.cli.options import CalibrationPath, Sources, TargetText
from station.cli.output import AsJson, emit, progress_bar
from station.cli.verdict import Limit, hold_against, rounded
from station.documents import CalibrationDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import cylinders_of_sources, distances_of_sources

app = typer.Typer(
    help="How good a calibration is, told by things whose size is known.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
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


@app.command()
def cylinder(
    sources: Sources,
    calibration: CalibrationPath,
    radius: Annotated[float, typer.Option(metavar="MM", help="Radius of the cylinder.")],
    axis: Annotated[
        str,
        typer.Option(
            metavar="free|square|X,Y,Z",
            help="Its axis: found with the radius (short arcs hardly tell it), square to the "
            "sheet, or its direction in the camera frame.",
        ),
    ] = "free",
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Measure the radius of a cylinder, one reading a picture."""
    if not 0.0 < radius < np.inf:
        raise InputUnusable(f"--radius {radius:g}; allowed: more than 0 mm")
    sensor = CalibrationDocument.read(calibration).laser_sensor()
    with progress_bar("cylinder") as progress:
        readings = cylinders_of_sources(
            sources,
            sensor,
            radius,
            axis_in_cam=_axis(axis, sensor.plane.normal_in_cam),
            progress=progress,
        )
    measured = [reading for reading in readings if not reading.reason]
    if not measured:
        raise NothingMeasurable(
            f"no cylinder of radius {radius:g} mm; {readings[0].name}: {readings[0].reason}"
        )
    rms = _rms(np.array([reading.radius_mm - radius for reading in measured]))
    mean, u95 = _weighted_mean(measured)
    data = {
        "nominal_mm": radius,
        "axis": axis,
        "rms_mm": rms,
        "mean_mm": mean,
        "mean_u95_mm": u95,
        "readings": [_reading_data(reading) for reading in measured],
        "left_out": {reading.name: reading.reason for reading in readings if reading.reason},
        "limit_mm": limit,
    }
    lines = [_reading_line(reading, radius) for reading in readings]
    lines.append(
        f"RMS of the radius {rms:.4f} mm; weighted mean {mean:.4f} mm, scatter alone "
        f"+-{u95:.4f} mm (95 %), {len(measured)} placements, axis {axis}"
    )
    emit(data, "\n".join(lines), as_json=as_json)
    hold_against(limit, rms, "RMS of the radius")


def _axis(text: str, normal_in_cam: FloatArray) -> FloatArray | None:
    if text == "free":
        return None
    if text == "square":
        return normal_in_cam
    try:
        axis = np.array([float(part) for part in text.split(",")])
    except ValueError:
        axis = np.empty(0)
    if not (axis.shape == (3,) and 0.0 < float(np.linalg.norm(axis)) < np.inf):
        raise InputUnusable(f"--axis {text!r}; allowed: free, square, or X,Y,Z of its direction")
    axis = np.asarray(axis / np.linalg.norm(axis))
    if not abs(float(axis @ normal_in_cam)) > 0.5:
        raise InputUnusable(
            f"--axis {text!r} lies more than 60 degrees from square to the sheet; allowed: less"
        )
    return axis


def _weighted_mean(readings: list[CylinderReading]) -> tuple[float, float]:
    weight = np.array([reading.u95_mm for reading in readings]) ** -2.0
    mean = float(weight @ [reading.radius_mm for reading in readings] / weight.sum())
    return mean, float(weight.sum() ** -0.5)


def _reading_data(reading: CylinderReading) -> dict[str, Any]:
    return {
        "name": reading.name,
        "radius_mm": reading.radius_mm,
        "u95_mm": reading.u95_mm,
        "rms_mm": reading.rms_mm,
        "tilt_deg": reading.tilt_deg,
        "arc_deg": reading.arc_deg,
        "points": reading.points,
    }


def _reading_line(reading: CylinderReading, nominal_mm: float) -> str:
    if reading.reason:
        return f"left out {reading.name}: {reading.reason}"
    return (
        f"{reading.name}: radius {reading.radius_mm:.4f} +- {reading.u95_mm:.4f} mm (95 %), off "
        f"by {reading.radius_mm - nominal_mm:+.4f} mm; points {reading.rms_mm:.4f} mm RMS, tilt "
        f"{reading.tilt_deg:.1f} deg, {reading.arc_deg:.0f} deg of the section"
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
