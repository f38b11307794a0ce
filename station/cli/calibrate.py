"""`station calibrate`: from pictures of a target to calibration.json."""

from pathlib import Path
from typing import Annotated

import typer

from calib import Method, Target
from station.cli.options import SensorOption, Sources, TargetText
from station.cli.output import AsJson, emit, progress_bar
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    write_whole,
)
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import calibrate_sources
from station.report import calibration_report


def calibrate(
    sources: Sources,
    target: TargetText,
    out: Annotated[Path, typer.Option(metavar="FILE", help="calibration.json to write.")],
    camera: Annotated[
        Path | None, typer.Option(metavar="FILE", help="camera.json; solved with the rest without.")
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WIDTHxHEIGHT", help="Size of the pictures, where only points are given."
        ),
    ] = None,
    method: Annotated[Method, typer.Option(help="How the light plane is solved.")] = Method.JOINT,
    laser_off: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="SOURCE", help="The same poses with the laser off, in the same order."
        ),
    ] = None,
    points: Annotated[
        Path | None, typer.Option(metavar="FILE", help="points.csv to write: every point.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Report to write: one page of HTML.")
    ] = None,
    mounting: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Survey of the sensor's place (JSON).")
    ] = None,
    sensor: SensorOption = None,
    as_json: AsJson = False,
) -> None:
    """Solve the light plane (and the camera, where none is given) from pictures of a target."""
    with progress_bar("calibrate") as progress:
        outcome = calibrate_sources(
            sources,
            Target.parse(target),
            sensor=sensor,
            camera=CameraDocument.read(camera).model() if camera else None,
            size_px=_size_px(size) if size else None,
            method=method,
            laser_off=laser_off or (),
            mounting=MountingDocument.read(mounting).settings() if mounting else None,
            progress=progress,
        )
    document = outcome.document
    document.write(out)
    if points is not None:
        write_whole(points, outcome.points_csv)
    if report is not None:
        write_whole(report, calibration_report(document, outcome.points_csv, sources))
    emit(document.model_dump(mode="json"), _text(document, out), as_json=as_json)
    failed = [name for name, gate in document.quality.items() if not gate.passed]
    if failed:
        raise NothingMeasurable(
            f"{out} was written but fails the gates {', '.join(failed)}; look at the pictures "
            "named in it, take more poses, then calibrate again"
        )


def _size_px(text: str) -> tuple[int, int]:
    width, times, height = text.partition("x")
    if not (times and width.isdigit() and height.isdigit() and int(width) * int(height) > 0):
        raise InputUnusable(f"size {text!r} does not parse; allowed: WIDTHxHEIGHT, as 2048x1088")
    return int(width), int(height)


def _text(document: CalibrationDocument, out: Path) -> str:
    plane = document.plane
    lines = [
        f"plane {plane.a:+.6f} x {plane.b:+.6f} y {plane.c:+.6f} z {plane.d:+.4f} = 0 (mm)",
        f"rms dots {document.rms.dots_px:.3f} px, stripe {document.rms.stripe_px:.3f} px, "
        f"{len(document.poses)} pictures used",
    ]
    lines += [
        f"{name} {gate.value:.4g} (limit {gate.limit:g}) {'passed' if gate.passed else 'FAILED'}"
        for name, gate in document.quality.items()
    ]
    lines += [f"left out {name}: {reason}" for name, reason in document.left_out.items()]
    lines += [f"warning: {warning}" for warning in document.warnings]
    return "\n".join([*lines, f"written to {out}"])
