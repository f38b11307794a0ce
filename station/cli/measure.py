"""`station measure`: from frames of passing wheels to results.json."""

from typing import Annotated

import typer

from station.cli.options import CalibrationPaths, Reference, Sources
from station.cli.output import AsJson, emit, progress_bar
from station.cli.outputs import (
    Config,
    Miniprof,
    Out,
    Outputs,
    Plot,
    Profiles,
    limits_in_force,
    refuse_same_file,
    sides_known,
)
from station.cli.readings_text import text_of
from station.documents import CalibrationDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import load_reference, measure_sources, measure_train


def measure(
    sources: Sources,
    calibration: CalibrationPaths,
    reference: Reference = "S1002",
    out: Out = None,
    profiles: Profiles = None,
    miniprof: Miniprof = None,
    plot: Plot = None,
    config: Config = None,
    axles: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help="Axles of the train, where several sensors saw it."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure the wheels in recordings, pictures or folders.

    With a calibration of each of several sensors: their recordings of one pass, axle for axle.
    """
    outputs = Outputs(out, profiles, miniprof, plot)
    refuse_same_file(outputs, [*sources, *calibration])
    limits = limits_in_force(config)
    calibrations = [CalibrationDocument.read(path) for path in calibration]
    if axles is not None and len(calibrations) < 2:
        raise InputUnusable(
            "--axles is of a train that several sensors saw; give the calibration of each"
        )
    with progress_bar("measure") as progress:
        if len(calibrations) > 1:
            document = measure_train(
                sources,
                calibrations,
                sides=sides_known(config, calibrations),
                counted=axles,
                reference=reference,
                limits=limits,
                progress=progress,
            )
        else:
            document = measure_sources(
                sources, calibrations[0], reference=reference, limits=limits, progress=progress
            )
    outputs.write(document, lambda: load_reference(reference))
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
    if not document.measured:
        reasons = dict.fromkeys(wheel.reason or "" for wheel in document.wheels)
        raise NothingMeasurable(
            f"none of {len(document.wheels)} wheels could be measured: {'; '.join(reasons)}"
        )
