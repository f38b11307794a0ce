"""`station replay`: recordings measured again, on all cores, into one table."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import CalibrationPath, Reference
from station.cli.output import AsJson, emit, progress_bar
from station.documents import CalibrationDocument
from station.errors import NothingMeasurable
from station.replay import ReplayReport, replay_recordings


def replay(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE.mcap...", help="Recordings of one sensor.")
    ],
    calibration: CalibrationPath,
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help="Table to write: results.parquet, .csv or .json."),
    ],
    reference: Reference = "S1002",
    as_json: AsJson = False,
) -> None:
    """Measure recordings again, a row a wheel: the same readings as when they were made."""
    with progress_bar("replay") as progress:
        report = replay_recordings(
            files,
            CalibrationDocument.read(calibration),
            out,
            reference=reference,
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
