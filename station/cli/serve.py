"""`station serve`: the station, until it is told to stop."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from station.backups import newest_restorable
from station.cli.output import AsJson, emit
from station.errors import StoreNewer
from station.operations import DataLayout
from station.serve import log_as, supervise
from station.settings import credential, load_settings

_DEFAULT_CONFIG = Path("station.toml")


def serve(
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Run the station: page and API, cameras, jobs.  SIGTERM or Ctrl-C ends it in order."""
    settings = load_settings(config)
    log_as("supervisor", settings.log_level)

    def announce(url: str, seconds: float) -> None:
        document = {"ready": True, "url": url, "seconds": round(seconds, 2)}
        emit(document, f"station ready at {url} after {seconds:.1f} s", as_json=as_json)
        sys.stdout.flush()

    try:
        supervise(
            settings,
            admin_key=credential("admin_key", config),
            say=lambda line: typer.echo(line, err=True),
            announce=announce,
        )
    except StoreNewer as error:
        backup = newest_restorable(DataLayout.of(settings))
        if backup is None:
            raise
        raise StoreNewer(f"{error}: station restore {backup} --config {config}") from error
