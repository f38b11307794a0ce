"""`station fleet`: what many stations have sent to one database."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict
from datetime import datetime, timedelta
from pathlib import Path
from typing import Annotated, Any

import typer
from sqlalchemy.orm import Session

from station.cli.fleet_text import health_text, status_text, trend_text
from station.cli.output import AsJson, emit
from station.errors import NotFound, NothingMeasurable, StoreUnusable
from station.fleet import (
    MOST_PASSES,
    Fleet,
    FleetQuantity,
    FleetTrend,
    Wear,
    ensure_given,
    ensure_ready,
    fleet_revision,
    fleet_trend,
    migrate_fleet,
    sensor_healths,
    station_states,
)
from station.settings import credential, load_settings

app = typer.Typer(
    help="Many stations, one database: what they sent, side by side.", no_args_is_help=True
)

Url = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        help="Database of the fleet: postgresql://USER:PASSWORD@HOST/DATABASE or sqlite:////FILE; "
        "absent: STATION_FLEET_URL, or [fleet] of the settings.",
    ),
]
Config = Annotated[Path, typer.Option(metavar="FILE", help="Settings of a station (TOML).")]
_DEFAULT_CONFIG = Path("station.toml")


@app.command("init")
def init_fleet(url: Url = None, config: Config = _DEFAULT_CONFIG, as_json: AsJson = False) -> None:
    """Make the fleet's tables, or bring them to this version; what is in them stays."""
    given = _url(url, config)
    before = fleet_revision(given)
    migrate_fleet(given)
    now = fleet_revision(given)
    text = f"the fleet's database is at revision {now}" + (" as before" if before == now else "")
    emit({"before": before, "revision": now}, text, as_json=as_json)


@app.command("status")
def fleet_status(
    url: Url = None, config: Config = _DEFAULT_CONFIG, as_json: AsJson = False
) -> None:
    """Tell how each station is: when it was heard, what it has still to send, its alarms."""
    with _asked(url, config) as session:
        states = station_states(session)
    document = {"stations": [_plain(asdict(each)) for each in states]}
    emit(document, status_text(states), as_json=as_json)


@app.command("health")
def fleet_health(
    station: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of this station alone.")
    ] = None,
    url: Url = None,
    config: Config = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Tell how the calibration of each sensor is: its age, its residuals, its drift.

    Exit 1: one of them may measure wrongly.
    """
    with _asked(url, config) as session:
        healths = sensor_healths(session, station=station)
    document = {"sensors": [_plain(asdict(each)) for each in healths]}
    emit(document, health_text(healths), as_json=as_json)
    if any(each.doubtful for each in healths):
        raise typer.Exit(1)


@app.command("trend")
def wheelset_trend(
    wheelset: Annotated[str, typer.Argument(help="Name of the wheelset, as consists give it.")],
    last: Annotated[
        int, typer.Option(min=2, max=MOST_PASSES, help="Passes of each wheel, the newest.")
    ] = 200,
    url: Url = None,
    config: Config = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Tell how a wheelset wears over all stations, and whether they read it alike.

    Exit 1: no station has measured it.
    """
    try:
        with _asked(url, config) as session:
            trend = fleet_trend(session, wheelset, most=last)
    except NotFound as error:
        raise NothingMeasurable(str(error)) from error
    emit(_trend_as_data(trend), trend_text(trend), as_json=as_json)


@app.command("page")
def fleet_page(
    out: Annotated[
        Path, typer.Option(metavar="FOLDER", help="Where the pages go; index.html is the first.")
    ],
    last: Annotated[
        int, typer.Option(min=2, max=MOST_PASSES, help="Passes of each wheel, the newest.")
    ] = 100,
    due_after_days: Annotated[
        int, typer.Option("--due-after", min=1, help="Days after which a calibration is due.")
    ] = 365,
    url: Url = None,
    config: Config = _DEFAULT_CONFIG,
    as_json: AsJson = False,
) -> None:
    """Write what the fleet knows as a folder of pages, for any web server or none.

    Run again it writes what has changed.  Where the database is not reached, the pages stay as
    they are and the first says so; exit 2.
    """
    from station.fleet.pages import note_unreached, write_pages  # noqa: PLC0415  they take long

    due_after = timedelta(days=due_after_days)
    try:
        with _asked(url, config) as session:
            found = write_pages(session, out, last=last, due_after=due_after)
    except StoreUnusable as error:
        note_unreached(out, str(error))
        raise
    text = f"{out}: {found.pages} pages, {found.written} new or changed, {found.removed} removed"
    emit(asdict(found), text, as_json=as_json)


@contextmanager
def _asked(url: str | None, config: Path) -> Generator[Session]:
    given = _url(url, config)
    ensure_ready(given)
    fleet = Fleet.open_to_look(given)
    try:
        with fleet.look() as session:
            yield session
    finally:
        fleet.close()


def _url(url: str | None, config: Path) -> str:
    found = url or credential("fleet_url", config)
    if found is None and config.exists():
        settings = load_settings(config)
        found = None if settings.fleet is None else settings.fleet.url
    return ensure_given(found)


def _trend_as_data(trend: FleetTrend) -> dict[str, Any]:
    return {
        "wheelset": trend.wheelset,
        "stations": list(trend.stations),
        "sides": [
            {
                "side": side.side.value,
                "quantities": {
                    name.value: _quantity_as_data(each) for name, each in side.quantities.items()
                },
            }
            for side in trend.sides
        ],
    }


def _quantity_as_data(found: FleetQuantity) -> dict[str, Any]:
    agreement = found.agreement
    return {
        "values": [_plain(asdict(value)) for value in found.values],
        "compared": found.compared,
        "wear": None if found.wear is None else _wear_as_data(found.wear),
        "agreement": None
        if agreement is None
        else {
            "held_against": agreement.held_against,
            "per_day": asdict(agreement.per_day),
            "offsets": [
                {**asdict(offset), "agrees": offset.agrees} for offset in agreement.offsets
            ],
        },
    }


def _wear_as_data(wear: Wear) -> dict[str, Any]:
    return {
        "held_against": wear.held_against,
        "level_mm": wear.level_mm,
        "u95_mm": wear.u95_mm,
        "per_day": asdict(wear.per_day),
    }


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    """Return the same as JSON has it."""
    return {
        name: value.isoformat() if isinstance(value, datetime) else value
        for name, value in values.items()
    }
