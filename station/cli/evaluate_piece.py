"""`station evaluate piece` and `step`: whether the sensor still tells the truth."""

from pathlib import Path
from typing import Annotated

import typer

from measure import MeasureError, Piece
from station.cli.options import CalibrationPath, Sources
from station.cli.output import AsJson, emit, progress_bar
from station.cli.verdict import Limit
from station.documents import (
    CalibrationDocument,
    PieceCheck,
    PieceDocument,
    PiecePictureDocument,
    RigDocument,
)
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import check_piece, check_piece_on_rig

LaserOff = Annotated[
    list[Path] | None,
    typer.Option(metavar="SOURCE", help="The same with the laser off: one for all, or for each."),
]
Temperature = Annotated[
    float | None,
    typer.Option(metavar="C", min=-60.0, max=80.0, help="Of the piece; unknown without."),
]
Out = Annotated[Path | None, typer.Option(metavar="FILE", help="Where the check is kept, as JSON.")]


Since = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="An earlier check: a held piece must be where it was."),
]


def piece(
    sources: Sources,
    piece: Annotated[
        Path, typer.Option("--piece", metavar="FILE", help="piece.json: its certified profile.")
    ],
    calibration: Annotated[
        Path | None,
        typer.Option("--calibration", metavar="FILE", help="calibration.json of the sensor."),
    ] = None,
    rig: Annotated[
        Path | None,
        typer.Option(
            "--rig",
            metavar="FILE",
            help="rig.json: all its sensors saw the piece, one SOURCE each.",
        ),
    ] = None,
    limit: Limit = None,
    laser_off: LaserOff = None,
    temperature: Temperature = None,
    since: Since = None,
    out: Out = None,
    as_json: AsJson = False,
) -> None:
    """Measure a reference piece, by one sensor or a whole rig, and hold it to its certificate."""
    known = PieceDocument.read(piece).piece()
    earlier = None if since is None else PieceCheck.read(since)
    with progress_bar("piece") as progress:
        if rig is not None and calibration is None:
            if earlier is not None:
                raise InputUnusable(
                    "--since compares places on one sheet, a rig has several; leave it out, or "
                    "give --calibration and the pictures of one sensor"
                )
            check = check_piece_on_rig(
                sources,
                RigDocument.read(rig),
                known,
                laser_off=laser_off or (),
                limit_mm=limit,
                temperature_c=temperature,
                progress=progress,
            )
        elif calibration is not None and rig is None:
            check = check_piece(
                sources,
                CalibrationDocument.read(calibration),
                known,
                laser_off=laser_off or (),
                limit_mm=limit,
                temperature_c=temperature,
                since=earlier,
                progress=progress,
            )
        else:
            raise InputUnusable(
                "give --calibration of one sensor, or --rig of several that saw the piece together"
            )
    _answer(check, out, as_json=as_json)


def step(
    sources: Sources,
    calibration: CalibrationPath,
    height: Annotated[float, typer.Option(metavar="MM", help="Height of the step.")],
    width: Annotated[
        float, typer.Option(metavar="MM", help="How wide both levels are, at least.")
    ] = 20.0,
    u95: Annotated[float, typer.Option(metavar="MM", min=0.0, help="Of the height.")] = 0.0,
    limit: Limit = None,
    laser_off: LaserOff = None,
    out: Out = None,
    as_json: AsJson = False,
) -> None:
    """Measure the height of a step and hold it against what it should be."""
    try:
        known = Piece.step(height, width_mm=width, u95_mm=u95)
    except MeasureError as error:
        raise InputUnusable(str(error)) from error
    document = CalibrationDocument.read(calibration)
    with progress_bar("step") as progress:
        check = check_piece(
            sources,
            document,
            known,
            laser_off=laser_off or (),
            limit_mm=limit,
            progress=progress,
        )
    _answer(check, out, as_json=as_json)


def _answer(check: PieceCheck, out: Path | None, *, as_json: bool) -> None:
    if out is not None:
        check.write(out)
    emit(check.model_dump(mode="json"), "\n".join(_lines(check)), as_json=as_json)
    if not check.passed:
        raise NothingMeasurable(f"{check.piece}: {check.verdict.value}: {check.reason}")


def _lines(check: PieceCheck) -> list[str]:
    lines = [_of_picture(picture) for picture in check.pictures]
    if check.deviations:
        lines.append(f"{'':14} {'certified':>10} {'found':>10} {'off':>9} {'u95':>8}  mm")
    lines += [
        f"{one.name:14} {one.certified:10.4f} {one.found:10.4f} {one.off:+9.4f} {one.u95:8.4f}  "
        f"{one.verdict.value}"
        for one in check.deviations
    ]
    if check.profile:
        worst = max(check.profile, key=lambda one: abs(one.off))
        lines.append(
            f"profile: {len(check.profile)} parts, the farthest, {worst.certified:.1f} mm along "
            f"it, off by {worst.off:+.4f} +- {worst.u95:.4f} mm"
        )
    lines += [f"{one.name}: found from {one.found_from:.2g} {one.unit}" for one in check.powers]
    lines += check.notes
    lines.append(
        f"{check.verdict.value}: {check.reason} (allowed: {check.coverage_factor:.2f} u95"
        + (f", or {check.limit_mm:g} mm)" if check.limit_mm is not None else ")")
    )
    return lines


def _of_picture(picture: PiecePictureDocument) -> str:
    name = f"{picture.name} {picture.sensor}" if picture.sensor else picture.name
    if picture.reason:
        return f"left out {name}: {picture.reason}"
    return f"{name}: {picture.points} points, {picture.rms_mm:.4f} mm RMS"
