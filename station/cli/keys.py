"""`station keys`: who may call the station."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any

import typer

from station.cli.output import AsJson, emit
from station.cli.person import person
from station.errors import InputUnusable, StateConflict
from station.operations import DataLayout, Keys, key_id_of, utc_now
from station.settings import load_settings
from station.store import Key, Store, migrate
from station.store.callers import Scope, usable
from station.worker import held

app = typer.Typer(
    help="Who may call the station: keys, each with a name and scopes.", no_args_is_help=True
)

Config = Annotated[Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")]
KeyId = Annotated[
    str, typer.Argument(metavar="ID", help="Id of the key: the second part of its text.")
]
Days = Annotated[
    float | None,
    typer.Option("--expires-days", metavar="DAYS", help="Days it is good for; else until revoked."),
]
_DEFAULT_CONFIG = Path("station.toml")


@app.command("create")
def create_key(
    name: Annotated[str, typer.Argument(help="Whose key it is: who did what is told by it.")],
    scope: Annotated[
        list[Scope],
        typer.Option(
            help="What it opens; once for each. operate, calibrate: read too. admin: all."
        ),
    ],
    expires_days: Days = None,
    config: Config = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Make a key.  Its text is printed once and kept nowhere."""
    keys = _keys(config)
    text = keys.create(name, scope, _after(keys.now, expires_days))
    _emit_new(text, as_json=as_json)


@app.command("list")
def list_keys(config: Config = _DEFAULT_CONFIG, as_json: AsJson = False) -> None:
    """List the keys, those that are no longer good included."""
    keys = _keys(config)
    found = [_as_data(key, keys.now) for key in keys.list()]
    text = "\n".join(map(_line, found)) or "no key was ever made"
    emit({"keys": found}, text, as_json=as_json)


@app.command("rotate")
def rotate_key(
    key_id: KeyId,
    keep_hours: Annotated[
        float, typer.Option(metavar="HOURS", help="Hours the old one stays good for the change.")
    ] = 24.0,
    expires_days: Days = None,
    config: Config = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Make a key in place of another.  Its text is printed once and kept nowhere."""
    keys = _keys(config)
    overlap = _duration(keep_hours / 24.0)
    text = keys.rotate(_id_in(key_id), overlap, _after(keys.now, expires_days))
    _emit_new(text, as_json=as_json)


@app.command("revoke")
def revoke_key(key_id: KeyId, config: Config = _DEFAULT_CONFIG, as_json: AsJson = False) -> None:
    """Take a key back, from this moment on."""
    keys = _keys(config)
    key = keys.revoke(_id_in(key_id))
    emit(_as_data(key, keys.now), f"key {key.id} of {key.name} opens nothing more", as_json=as_json)


def _keys(config: Path) -> Keys:
    layout = DataLayout.of(load_settings(config))
    layout.ensure()
    try:
        with held(layout.station_lock, "a station"):
            migrate(layout.store_url)
    except StateConflict:
        pass  # A station runs, and brought its store up to date when it was started.
    return Keys(Store.open(layout.store_url), person(), utc_now())


def _id_in(text: str) -> str:
    # Whoever gives the whole key by mistake means its id.
    return key_id_of(text) if text.startswith("tl_") else text


def _duration(days: float) -> timedelta:
    if not (0.0 <= days <= 3650.0):
        raise InputUnusable(f"{days:g} days: give from 0 to 3650 (ten years)")
    return timedelta(days=days)


def _after(now: datetime, days: float | None) -> datetime | None:
    return None if days is None else now + _duration(days)


def _emit_new(text: str, *, as_json: bool) -> None:
    document = {"id": key_id_of(text), "key": text}
    emit(document, f"key {document['id']}, shown this once: {text}", as_json=as_json)


def _as_data(key: Key, now: datetime) -> dict[str, Any]:
    times = {
        name: None if (at := getattr(key, name)) is None else at.astimezone(UTC).isoformat()
        for name in ("created_at", "expires_at", "revoked_at", "last_used_at")
    }
    return {
        "id": key.id,
        "name": key.name,
        "scopes": key.scopes["scopes"],
        "good": usable(key, at=now),
        **times,
    }


def _line(key: dict[str, Any]) -> str:
    used = "never used" if key["last_used_at"] is None else f"used {_minute(key['last_used_at'])}"
    state = "good" if key["good"] else "revoked" if key["revoked_at"] else "expired"
    until = f" until {_minute(key['expires_at'])}" if key["good"] and key["expires_at"] else ""
    return f"{key['id']}  {key['name']}  {'+'.join(key['scopes'])}  {state}{until}, {used}"


def _minute(moment: str) -> str:
    return f"{moment[:16].replace('T', ' ')} UTC"
