"""`station rig`: sensors that look at the same wheel."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit
from station.cli.rig_calibrate import calibrate
from station.cli.rig_compare import compare
from station.cli.rig_text import text_of_rig
from station.documents import RigDocument

app = typer.Typer(
    help="Sensors that look at the same wheel: calibrate them together, and look at rigs.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command("calibrate")(calibrate)
app.command("compare")(compare)


@app.command("show")
def show(
    file: Annotated[Path, typer.Argument(metavar="RIG.json", help="A rig.")],
    as_json: AsJson = False,
) -> None:
    """Tell how the sensors of a rig stand, how surely, and what it rests on."""
    document = RigDocument.read(file)
    emit(document.model_dump(mode="json"), text_of_rig(document), as_json=as_json)
