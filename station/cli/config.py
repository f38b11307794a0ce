"""`station config`: the settings file, looked at before anything rests on it."""

import os
from pathlib import Path
from typing import Annotated, Any

import typer

from station.cli.config_explained import explained
from station.cli.output import AsJson, emit
from station.errors import InputUnusable
from station.limits import limits_of
from station.serve import ensure_tls_usable
from station.settings import StationSettings, load_settings

app = typer.Typer(help="The settings file of a station.", no_args_is_help=True)

_HIDDEN = "(hidden)"


@app.callback()
def _group() -> None:
    pass


@app.command()
def check(
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = Path("station.toml"),
    as_json: AsJson = False,
) -> None:
    """Check the settings and the files they name, and show what is in force, without secrets.

    Exit 0: a station can be started with them, as far as this tells. Exit 2: it cannot, and why.
    """
    settings = load_settings(config)
    ensure_tls_usable(settings.tls)
    limits_of(settings.limits)
    _ensure_data_dir_usable(settings.data_dir)
    emit(_shown(settings), f"{config}: fit to start a station with", as_json=as_json)


@app.command()
def explain(as_json: AsJson = False) -> None:
    """Explain every setting: what it means, its unit, and what holds where it is not given."""
    settings = list(explained(StationSettings))
    text = "\n".join(_line(each) for each in settings)
    emit({"settings": settings}, text, as_json=as_json)


def _line(setting: dict[str, Any]) -> str:
    if setting["table"]:
        return f"\n[{setting['name']}]\n    {setting['meaning']}"
    holds = "needed" if setting["needed"] else f"default {setting['default']!r}"
    return f"{setting['name']} ({holds})\n    {setting['meaning']}"


def _ensure_data_dir_usable(folder: Path) -> None:
    existing = next(each for each in (folder, *folder.parents) if each.exists())
    if not (existing.is_dir() and os.access(existing, os.W_OK | os.X_OK)):
        raise InputUnusable(
            f"data_dir {folder}: {existing} cannot be written to by this user; give it to the user "
            "the station runs as, or name another folder"
        )


def _shown(settings: StationSettings) -> dict[str, Any]:
    document = settings.model_dump(mode="json")
    if document["store_url"] is not None:
        document["store_url"] = _HIDDEN
    if document["fleet"] is not None and document["fleet"]["url"] is not None:
        document["fleet"]["url"] = _HIDDEN
    return document
