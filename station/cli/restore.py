"""`station restore`: a backup in the place of the store."""

from pathlib import Path
from typing import Annotated

import typer

from station.backups import restore_backup
from station.cli.output import AsJson, emit, progress_bar
from station.cli.person import person
from station.operations import DataLayout, utc_now
from station.settings import load_settings


def restore(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="What `station backup` wrote.")],
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = Path("station.toml"),
    as_json: AsJson = False,
) -> None:
    """Put a backup in the place of the store, which is kept aside; not while the station runs."""
    layout = DataLayout.of(load_settings(config))
    with progress_bar("restore") as progress:
        progress(0.0, "checking and copying")
        done = restore_backup(layout, file, by=person(), at=utc_now())
    aside = None if done.aside is None else str(done.aside)
    document = {"restored": str(file), "revision": done.revision, "aside": aside}
    before = "there was no store before" if aside is None else f"the store before is in {aside}"
    emit(document, f"{file} is the station's store now; {before}", as_json=as_json)
