"""`station gauge`: the same readings from a profile file instead of pictures."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import Reference
from station.cli.output import AsJson, emit
from station.cli.outputs import (
    Config,
    Miniprof,
    Out,
    Outputs,
    Plot,
    Profiles,
    limits_in_force,
    refuse_same_file,
)
from station.cli.readings_text import text_of
from station.errors import NothingMeasurable
from station.pipeline import gauge_files, load_reference


def gauge(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="PROFILE...", help="Profiles: MiniProf files or CSV of d,h."),
    ],
    reference: Reference = "S1002",
    assume_back: Annotated[
        bool,
        typer.Option(
            "--assume-back",
            help="Read thickness and gradient from d = 0 where no point shows the flange back.",
        ),
    ] = False,
    out: Out = None,
    profiles: Profiles = None,
    miniprof: Miniprof = None,
    plot: Plot = None,
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Read the gauges off profile files, where their headers say (L1, L2, L3) or as EN 15313."""
    outputs = Outputs(out, profiles, miniprof, plot)
    refuse_same_file(outputs, files)
    document = gauge_files(
        files, reference=reference, limits=limits_in_force(config), assume_back=assume_back
    )
    outputs.write(document, lambda: load_reference(reference))
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
    if not document.measured:
        reasons = dict.fromkeys(wheel.reason or "" for wheel in document.wheels)
        raise NothingMeasurable(
            f"none of {len(files)} profiles could be measured: {'; '.join(reasons)}"
        )
