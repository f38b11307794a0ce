"""`station evaluate cylinder`: the radius of a cylinder in several placements."""

from typing import Annotated, Any

import numpy as np
import typer

from calib import CylinderJudgement, CylinderReading, FloatArray
from station.cli.options import CalibrationPath, Sources
from station.cli.output import AsJson, emit, progress_bar
from station.cli.verdict import Limit, hold_against
from station.documents import CalibrationDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import cylinders_of_sources

_HELD = {
    "own": "each placement with an axis of its own",
    "one": "one axis for all placements",
    "known": "axis as given",
}


def cylinder(
    sources: Sources,
    calibration: CalibrationPath,
    radius: Annotated[float, typer.Option(metavar="MM", help="Radius of the cylinder.")],
    axis: Annotated[
        str,
        typer.Option(
            metavar="free|common|square|X,Y,Z",
            help="Its axis: free is found in each picture, with the one radius of all pictures; "
            "common is the same in all, as of a cylinder that was shifted and not turned; square "
            "is square to the sheet; X,Y,Z is its direction in the camera frame.",
        ),
    ] = "free",
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Measure the radius of one cylinder, shown in as many placements as there are pictures."""
    if not 0.0 < radius < np.inf:
        raise InputUnusable(f"--radius {radius:g}; allowed: more than 0 mm")
    sensor = CalibrationDocument.read(calibration).laser_sensor()
    with progress_bar("cylinder") as progress:
        judged = cylinders_of_sources(
            sources,
            sensor,
            radius,
            axis_in_cam=_axis(axis, sensor.plane.normal_in_cam),
            one_axis=axis == "common",
            progress=progress,
        )
    measured = [reading for reading in judged.readings if not reading.reason]
    if not measured:
        first = judged.readings[0]
        raise NothingMeasurable(
            f"no cylinder of radius {radius:g} mm; {first.name}: {first.reason}"
        )
    rms = _rms([reading.radius_mm - radius for reading in measured])
    rms_alone = _rms([reading.alone_mm - radius for reading in measured])
    data = {
        "nominal_mm": radius,
        "axis": axis,
        "radius_mm": judged.radius_mm,
        "u95_mm": judged.u95_mm,
        "rms_mm": rms,
        "rms_alone_mm": rms_alone,
        "readings": [_reading_data(reading) for reading in measured],
        "left_out": {r.name: r.reason for r in judged.readings if r.reason},
        "limit_mm": limit,
    }
    lines = [_reading_line(reading, radius) for reading in judged.readings]
    lines += _summary(judged, radius, rms, rms_alone)
    emit(data, "\n".join(lines), as_json=as_json)
    hold_against(limit, rms, "RMS of the radius")


def _axis(text: str, normal_in_cam: FloatArray) -> FloatArray | None:
    if text in {"free", "common"}:
        return None
    if text == "square":
        return normal_in_cam
    try:
        axis = np.array([float(part) for part in text.split(",")])
    except ValueError:
        axis = np.empty(0)
    if not (axis.shape == (3,) and 0.0 < float(np.linalg.norm(axis)) < np.inf):
        raise InputUnusable(
            f"--axis {text!r}; allowed: free, common, square, or X,Y,Z of its direction"
        )
    axis = np.asarray(axis / np.linalg.norm(axis))
    if not abs(float(axis @ normal_in_cam)) > 0.5:
        raise InputUnusable(
            f"--axis {text!r} lies more than 60 degrees from square to the sheet; allowed: less"
        )
    return axis


def _summary(
    judged: CylinderJudgement, nominal_mm: float, rms_mm: float, rms_alone_mm: float
) -> list[str]:
    count = sum(not reading.reason for reading in judged.readings)
    return [
        f"all together: radius {judged.radius_mm:.4f} +- {judged.u95_mm:.4f} mm (95 %), off by "
        f"{judged.radius_mm - nominal_mm:+.4f} mm; {count} placements, {_HELD[judged.axes]}",
        f"RMS of the radius {rms_mm:.4f} mm; each picture alone {rms_alone_mm:.4f} mm",
    ]


def _reading_data(reading: CylinderReading) -> dict[str, Any]:
    return {
        "name": reading.name,
        "radius_mm": reading.radius_mm,
        "u95_mm": reading.u95_mm,
        "alone_mm": reading.alone_mm,
        "alone_u95_mm": reading.alone_u95_mm,
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
        f"by {reading.radius_mm - nominal_mm:+.4f} mm; alone {reading.alone_mm:.4f} +- "
        f"{reading.alone_u95_mm:.4f}; points {reading.rms_mm:.4f} mm RMS, tilt "
        f"{reading.tilt_deg:.1f} deg, {reading.arc_deg:.0f} deg of the section"
    )


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
