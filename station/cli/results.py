"""`station results`: what was measured, written once more in another form."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit
from station.cli.outputs import Miniprof, Out, Outputs, Plot, Profiles, refuse_same_file
from station.cli.readings_text import text_of
from station.documents import MeasurementDocument
from station.pipeline import load_reference


def results(
    file: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="results.json of measure, gauge or replay.")
    ],
    reference: Annotated[
        str | None,
        typer.Option(
            metavar="S1002|LMA|FILE",
            help="What drawings show behind the profiles; the results' own where not given.",
        ),
    ] = None,
    out: Out = None,
    profiles: Profiles = None,
    miniprof: Miniprof = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Show results, and write them as tables, MiniProf files or drawings; nothing is measured."""
    outputs = Outputs(out, profiles, miniprof, plot)
    refuse_same_file(outputs, [file])
    document = MeasurementDocument.read(file)
    outputs.write(document, lambda: load_reference(reference or document.reference))
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
