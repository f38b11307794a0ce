"""`station replay`: recordings measured again, on all cores, into one table."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import OptionalCalibrations, Reference, RigPaths
from station.cli.output import AsJson, emit, progress_bar
from station.cli.outputs import Config, limits_in_force, sides_known, skews_known
from station.documents import CalibrationDocument, RigDocument
from station.errors import InputUnusable, NothingMeasurable
from station.replay import ReplayReport, replay_recordings


def replay(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE.mcap...", help="Recordings, of several sensors too."),
    ],
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help="Table to write: results.parquet, .csv or .json."),
    ],
    calibration: OptionalCalibrations = None,
    rig: RigPaths = None,
    reference: Reference = "S1002",
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Measure recordings again, a row a wheel: the same readings as when they were made.

    With rigs, or a calibration of each of several sensors, the wheels of a pass stand axle for
    axle.
    """
    calibrations = [CalibrationDocument.read(path) for path in calibration or ()]
    rigs = [RigDocument.read(path) for path in rig or ()]
    if not (calibrations or rigs):
        raise InputUnusable("nothing to measure with; give --calibration of the sensor, or --rig")
    with progress_bar("replay") as progress:
        report = replay_recordings(
            files,
            calibrations,
            out,
            rigs=rigs,
            reference=reference,
            limits=limits_in_force(config),
            sides=sides_known(config, calibrations),
            max_skew_us=skews_known(config),
            progress=progress,
        )
    emit(report.to_json(), _text(report), as_json=as_json)
    if report.refused:
        named = "; ".join(refusal.reason for refusal in report.refused)
        count = len(report.refused)
        raise NothingMeasurable(
            f"{count} of {count + report.recordings} recordings are not in the table: {named}"
        )
    if not report.measured:
        raise NothingMeasurable(
            f"none of {report.wheels} wheels could be measured; {out} has the reasons"
        )


def _text(report: ReplayReport) -> str:
    return (
        f"{report.measured} of {report.wheels} wheels measured, {report.recordings} recordings, "
        f"{report.frames} frames read\nwritten to {report.out}"
    )
