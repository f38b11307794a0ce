"""`station backup`: the store into a file, while the station runs."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from station.backups import make_backup
from station.cli.output import AsJson, emit, progress_bar
from station.operations import DataLayout
from station.settings import load_settings


def backup(
    out: Annotated[Path, typer.Option(metavar="FILE", help="New file of the backup.")],
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = Path("station.toml"),
    as_json: AsJson = False,
) -> None:
    """Write the store into a file, while the station runs: all it knows but the recordings.

    The checksum of the file stands beside it.
    """
    layout = DataLayout.of(load_settings(config))
    with progress_bar("backup") as progress:
        progress(0.0, "writing and checking")
        made = make_backup(layout.store_url, out)
        _note(layout, made.path)
    document = {
        "path": str(made.path),
        "size_bytes": made.size_bytes,
        "sha256": made.sha256,
        "revision": made.revision,
    }
    size_mb = made.size_bytes / 1e6
    text = f"{made.path}: {size_mb:.1f} MB, checked; recordings are not in it"
    emit(document, text, as_json=as_json)


def _note(layout: DataLayout, made: Path) -> None:
    """Leave for the station's metrics when there was a backup; one that cannot be noted is one."""
    with contextlib.suppress(OSError):
        layout.backup_note.write_text(f"{made.resolve()}\n")
