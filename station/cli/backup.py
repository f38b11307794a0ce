"""`station backup`: the store into a file, while the station runs."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from station.backups import drop_all_but, make_backup, next_in
from station.cli.output import AsJson, emit, progress_bar
from station.errors import InputUnusable
from station.operations import DataLayout, utc_now
from station.settings import load_settings
from station.store import revision_of


def backup(
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE|FOLDER", help="New file of the backup; in a folder, named by its time."
        ),
    ],
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = Path("station.toml"),
    keep: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Of those in the folder keep the N newest alone."),
    ] = None,
    if_any: Annotated[
        bool, typer.Option("--if-any", help="Where there is no store yet, be content.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write the store into a file, while the station runs: all it knows but the recordings.

    The checksum of the file stands beside it.
    """
    if keep is not None and not out.is_dir():
        raise InputUnusable(
            f"--keep is of a folder and {out} is none; make it, or leave --keep out"
        )
    layout = DataLayout.of(load_settings(config))
    if if_any and revision_of(layout.store_url) is None:
        emit({"path": None}, "there is no store yet: nothing to back up", as_json=as_json)
        return
    with progress_bar("backup") as progress:
        progress(0.0, "writing and checking")
        made = make_backup(layout.store_url, next_in(out, utc_now()) if out.is_dir() else out)
        _note(layout, made.path)
        # Once the new one is whole, and not before.
        dropped = [] if keep is None else _drop(out, keep)
    document = {
        "path": str(made.path),
        "size_bytes": made.size_bytes,
        "sha256": made.sha256,
        "revision": made.revision,
        "dropped": [str(path) for path in dropped],
    }
    size_mb = made.size_bytes / 1e6
    text = f"{made.path}: {size_mb:.1f} MB, checked; recordings are not in it"
    emit(document, text, as_json=as_json)


def _drop(folder: Path, keep: int) -> list[Path]:
    try:
        return drop_all_but(folder, keep)
    except OSError as error:
        raise InputUnusable(f"{folder}: an old backup cannot be deleted ({error})") from error


def _note(layout: DataLayout, made: Path) -> None:
    """Leave for the station's metrics when there was a backup; one that cannot be noted is one."""
    with contextlib.suppress(OSError):
        layout.backup_note.write_text(f"{made.resolve()}\n")
