"""`station measure`: from frames of passing wheels to results.json."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import OptionalCalibrations, Reference, RigPaths, Sources
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
    skews_known,
    track_known,
)
from station.cli.readings_text import text_of
from station.documents import CalibrationDocument, MeasurementDocument, RigDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import (
    load_reference,
    measure_rig,
    measure_sources,
    measure_train,
    sources_by_sensor,
)
from station.progress import Progress
from station.settings import MAX_SKEW_US


def measure(
    sources: Sources,
    calibration: OptionalCalibrations = None,
    rig: RigPaths = None,
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

    With a rig: one source of each of its sensors, measured together. With several rigs, or a
    calibration of each of several sensors: their recordings of one pass, axle for axle.
    """
    outputs = Outputs(out, profiles, miniprof, plot)
    refuse_same_file(outputs, [*sources, *(calibration or ()), *(rig or ())])
    rigs = [RigDocument.read(path) for path in rig or ()]
    calibrations = [CalibrationDocument.read(path) for path in calibration or ()]
    _ensure_calibrated(calibrations, rigs, axles)
    with progress_bar("measure") as progress:
        document = _measured(
            sources, calibrations, rigs, config, axles=axles, reference=reference, progress=progress
        )
    outputs.write(document, lambda: load_reference(reference))
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
    if not document.measured:
        reasons = dict.fromkeys(wheel.reason or "" for wheel in document.wheels)
        raise NothingMeasurable(
            f"none of {len(document.wheels)} wheels could be measured: {'; '.join(reasons)}"
        )


def _ensure_calibrated(
    calibrations: Sequence[CalibrationDocument], rigs: Sequence[RigDocument], axles: int | None
) -> None:
    if not (calibrations or rigs):
        raise InputUnusable("nothing to measure with; give --calibration of the sensor, or --rig")
    if axles is not None and len(calibrations) + len(rigs) < 2:
        raise InputUnusable(
            "--axles is of a train that several sensors saw; give the calibration of each"
        )


def _measured(
    sources: Sequence[Path],
    calibrations: Sequence[CalibrationDocument],
    rigs: Sequence[RigDocument],
    config: Path | None,
    *,
    axles: int | None,
    reference: str,
    progress: Progress,
) -> MeasurementDocument:
    limits, skews = limits_in_force(config), skews_known(config)
    in_rigs = {name for rig in rigs for name in rig.names}
    alone = [each for each in calibrations if each.sensor not in in_rigs]
    if len(rigs) == 1 and not alone:
        return measure_rig(
            sources_by_sensor(sources, rigs[0].names, all_wanted=False),
            rigs[0],
            calibrations=calibrations,
            max_skew_us=skews.get(rigs[0].rig, MAX_SKEW_US),
            reference=reference,
            limits=limits,
            progress=progress,
        )
    if len(calibrations) == 1 and not rigs:
        return measure_sources(
            sources, calibrations[0], reference=reference, limits=limits, progress=progress
        )
    return measure_train(
        sources,
        calibrations,
        rigs=rigs,
        sides=sides_known(config, alone),
        max_skew_us=skews,
        counted=axles,
        track=track_known(config),
        reference=reference,
        limits=limits,
        progress=progress,
    )
