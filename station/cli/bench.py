"""`station bench`: the figures of the README, measured here."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from station.bench import (
    BENCHES,
    CAPTURE_PARTS,
    DRAWN,
    Drawing,
    bench_service_kills,
    capture_benches,
    measure_benches,
)
from station.cli.output import AsJson, emit, progress_bar
from station.errors import InputUnusable
from station.progress import Progress
from station.replay import workers_at
from station.tables import Table

_CAPTURE, _MEASURE, _KILLS = "capture", "measure", "service-kills"


def bench(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help=f"One of {', '.join(BENCHES)}; all.")
    ] = None,
    part: Annotated[
        list[str] | None,
        typer.Option(help=f"Of capture: one of {', '.join(CAPTURE_PARTS)}; may be repeated."),
    ] = None,
    full: Annotated[
        bool,
        typer.Option("--full", help="Of capture, service-kills: as long as is asked of a station."),
    ] = False,
    minutes: Annotated[
        float | None,
        typer.Option(min=0.01, help="Of capture: how long one camera runs at full rate."),
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Of capture: where recordings go meanwhile. Of measure: MiniProf files.",
        ),
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help=f"Of {', '.join(DRAWN)}: the draws of a simulation by the workers of this Dask "
            "scheduler; the same figures however many they are. At tls:// as `station replay`.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure and print the figures of the README."""
    if name is not None and name not in BENCHES:
        raise InputUnusable(f"bench {name!r}; allowed: {', '.join(BENCHES)}")
    benches = dict(BENCHES) if name is None else {name: BENCHES[name]}
    if cluster is not None:
        if name not in DRAWN:
            raise InputUnusable(f"--cluster is of `station bench` {', '.join(DRAWN)}; name one")
        _emit({name: _drawn_by(cluster, name)}, as_json=as_json)
        return
    if name == _MEASURE and folder is not None:
        benches[name] = measure_benches(folder)
        folder = None
    if name == _KILLS and full:
        benches[name] = (partial(bench_service_kills, full=True),)
        full = False
    if part or full or minutes is not None or folder is not None:
        if name != _CAPTURE:
            raise InputUnusable(
                "--part, --full, --minutes are of `station bench capture`, --full also of "
                "`station bench service-kills`, --folder also of `station bench measure`"
            )
        benches[name] = capture_benches(
            part or CAPTURE_PARTS, full=full, minutes=minutes, folder=folder
        )
    tables = {one: _measured(one, measures) for one, measures in benches.items()}
    _emit(tables, as_json=as_json)


def _drawn_by(cluster: str, name: str) -> list[Table]:
    with workers_at(cluster) as crew:
        drawing = Drawing(crew)
        return _measured(name, [partial(draw, drawing=drawing) for draw in DRAWN[name]])


def _emit(tables: Mapping[str, Sequence[Table]], *, as_json: bool) -> None:
    emit(
        {one: [table.as_data() for table in some] for one, some in tables.items()},
        "\n\n".join(table.as_markdown() for some in tables.values() for table in some),
        as_json=as_json,
    )


def _measured(name: str, measures: Sequence[Callable[[Progress], Table]]) -> list[Table]:
    with progress_bar(name) as progress:
        return [measure(progress) for measure in measures]
