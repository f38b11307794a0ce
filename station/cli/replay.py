"""`station replay`: recordings measured again, on all cores or many machines, into tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import OptionalCalibrations, Reference, RigPaths
from station.cli.output import AsJson, emit, progress_bar
from station.cli.outputs import Config, limits_in_force, sides_known, skews_known
from station.documents import CalibrationDocument, RigDocument
from station.errors import InputUnusable, NothingMeasurable
from station.replay import Means, Refusal, Replay, ReplayForecast, ReplayReport
from station.tables import Table

_NAMED_IN_LINE = 3


def replay(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE.mcap|FOLDER|URL...",
            help="Recordings, of several sensors too; folders of them; URLs of both, as s3://.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE|DIR",
            help="Table to write: results.parquet, .csv or .json; or a folder, which takes a "
            "Parquet table of each recording.",
        ),
    ],
    calibration: OptionalCalibrations = None,
    rig: RigPaths = None,
    reference: Reference = "S1002",
    config: Config = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Scheduler of a Dask cluster, as tcp://HOST:8786; its workers read the same "
            "paths or URLs. At tls:// the certificates are those of Dask's configuration, "
            "distributed.comm.tls.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes on this machine; as many as it has cores."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say what there is to measure.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Measure recordings again, a row a wheel: the same readings as when they were made.

    With rigs, or a calibration of each of several sensors, the wheels of a pass stand axle for
    axle. The same command after a kill goes on where it was.
    """
    if cluster is not None and workers is not None:
        raise InputUnusable("--workers is of this machine, --cluster of others; give one of them")
    planned = Replay(sources, _means(calibration, rig, reference, config), out)
    if dry_run:
        forecast = planned.forecast()
        emit(forecast.to_json(), _forecast_text(forecast), as_json=as_json)
        _refuse_refused(forecast.refused, forecast.recordings, "would not be in the table")
        return
    with progress_bar("replay") as progress:
        report = planned.run(cluster=cluster, workers=workers, progress=progress)
    emit(report.to_json(), _text(report), as_json=as_json)
    _refuse_refused(report.refused, report.recordings, "are not in the table")
    if not report.measured:
        raise NothingMeasurable(
            f"none of {report.wheels} wheels could be measured; {out} has the reasons"
        )


def _means(
    calibrations: list[Path] | None, rigs: list[Path] | None, reference: str, config: Path | None
) -> Means:
    """Return what to measure with, of the files named on the command line."""
    documents = [CalibrationDocument.read(path) for path in calibrations or ()]
    return Means.of(
        documents,
        rigs=[RigDocument.read(path) for path in rigs or ()],
        reference=reference,
        limits=limits_in_force(config),
        sides=sides_known(config, documents),
        max_skew_us=skews_known(config),
    )


def _refuse_refused(refused: Sequence[Refusal], others: int, what: str) -> None:
    if not refused:
        return
    named = "; ".join(refusal.reason for refusal in refused[:_NAMED_IN_LINE])
    more = f"; and {len(refused) - _NAMED_IN_LINE} more" if len(refused) > _NAMED_IN_LINE else ""
    raise NothingMeasurable(
        f"{len(refused)} of {len(refused) + others} recordings {what}: {named}{more}"
    )


def _forecast_text(forecast: ReplayForecast) -> str:
    return (
        f"{forecast.recordings} recordings in {forecast.tasks} tasks, {forecast.found_measured} "
        f"of them done before; about {forecast.frames} frames to read"
        f"{_refused_text(forecast.refused)}"
    )


def _text(report: ReplayReport) -> str:
    before = f", {report.found_measured} measured before" if report.found_measured else ""
    again = "; the same command tries what is not in it again, and that alone"
    return (
        f"{report.measured} of {report.wheels} wheels measured, {report.recordings} recordings"
        f"{before}, {report.frames} frames read\nwritten to {report.out}"
        f"{again if report.refused else ''}{_refused_text(report.refused)}"
    )


def _refused_text(refused: Sequence[Refusal]) -> str:
    if not refused:
        return ""
    rows = [{"recording": one.recording, "why": one.reason} for one in refused]
    return f"\n\n{Table('Not in the table', rows).as_markdown()}"
