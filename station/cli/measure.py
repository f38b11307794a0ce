"""`station measure`: from frames of passing wheels to results.json."""

from pathlib import Path
from typing import Annotated

import typer

from measure import Quantity
from station.cli.options import CalibrationPath, Reference, Sources
from station.cli.output import AsJson, emit, progress_bar
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    ReadingDocument,
    WheelDocument,
    write_whole,
)
from station.errors import NothingMeasurable
from station.pipeline import load_reference, measure_sources
from station.plots import profile_svg

_SHOWN = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR,
)


def measure(
    sources: Sources,
    calibration: CalibrationPath,
    reference: Reference = "S1002",
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="results.json to write.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Profile of the first wheel as SVG.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure the wheels in recordings, pictures or folders."""
    with progress_bar("measure") as progress:
        document = measure_sources(
            sources,
            CalibrationDocument.read(calibration),
            reference=reference,
            progress=progress,
        )
    if out is not None:
        document.write(out)
    if plot is not None:
        _plot(document, reference, plot)
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
    if not document.measured:
        reasons = dict.fromkeys(wheel.reason or "" for wheel in document.wheels)
        raise NothingMeasurable(
            f"none of {len(document.wheels)} wheels could be measured: {'; '.join(reasons)}"
        )


def _plot(document: MeasurementDocument, reference: str, path: Path) -> None:
    measured = next((wheel for wheel in document.wheels if wheel.profile is not None), None)
    if measured is not None:
        write_whole(path, profile_svg(measured, load_reference(reference)))


def text_of(document: MeasurementDocument) -> str:
    """Return one line a wheel, readings with their 95 % uncertainty."""
    lines = [_line(wheel) for wheel in document.wheels]
    return "\n".join([*lines, f"{document.measured} of {len(document.wheels)} wheels measured"])


def _line(wheel: WheelDocument) -> str:
    where = wheel.source if wheel.frame is None else f"{wheel.source} frame {wheel.frame}"
    if wheel.reason is not None:
        return f"{where}: not measured: {wheel.reason}"
    shown = (f"{name.value} {_shown(wheel.readings[name])}" for name in _SHOWN)
    return f"{where}: {', '.join(shown)}"


def _shown(reading: ReadingDocument) -> str:
    if reading.value is None:
        return "missing"
    return f"{reading.value:.3f} ± {reading.u95:.3f}"
