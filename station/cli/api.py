"""`station api`: the contract that programs are written against."""

import json
from pathlib import Path
from typing import Annotated

import typer

from station.api import contract
from station.cli.output import AsJson, emit

app = typer.Typer(help="The contract of the station's API.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """The contract of the station's API."""  # noqa: D401  help text


@app.command("openapi")
def print_openapi(
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write it to a file instead.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print the contract as OpenAPI; it is the same for every station."""
    document = contract()
    if out is None:
        emit(document, json.dumps(document, indent=2), as_json=as_json)
        return
    out.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    emit({"written": str(out)}, f"{out} written", as_json=as_json)
