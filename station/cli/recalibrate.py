"""`station recalibrate`: what the nightly job does, now."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any
from uuid import uuid4

import typer

from station.cli.options import SensorOption
from station.cli.output import AsJson, emit
from station.client import StationClient
from station.errors import InputUnusable, NothingMeasurable
from station.operations import DataLayout, sensor_given
from station.serve import log_as
from station.settings import StationSettings, credential, load_settings
from station.worker import is_held, recalibrate_here

_DEFAULT_CONFIG = Path("station.toml")
_ANYWHERE = {"0.0.0.0": "127.0.0.1", "::": "::1"}

Result = dict[str, Any]


def recalibrate(
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = _DEFAULT_CONFIG,
    sensor: SensorOption = None,
    url: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Of the running station; by its settings otherwise."),
    ] = None,
    timeout: Annotated[
        float, typer.Option(metavar="S", min=1.0, help="How long to wait for a running station.")
    ] = 4 * 3600.0,
    as_json: AsJson = False,
) -> None:
    """Recalibrate a sensor, or all that are calibrated, from their new calibration sessions.

    A running station does it, with the key in STATION_KEY; otherwise it is done here. Exit 0: kept
    or activated. Exit 1: a person is asked, or there is an alarm. Exit 2: it could not be done.
    """
    settings = load_settings(config)
    if sensor is not None:
        sensor_given(settings, sensor)
    if is_held(DataLayout.of(settings).station_lock):
        key = credential("key", config) or credential("admin_key", config)
        results = _by_station(settings, key, sensor, url, timeout)
    else:
        results = _here(settings, sensor)
    emit({"recalibrations": results}, "\n".join(map(_text, results)), as_json=as_json)
    _leave(results)


def _by_station(
    settings: StationSettings,
    key: str | None,
    sensor: str | None,
    url: str | None,
    timeout_s: float,
) -> list[Result]:
    if key is None:
        raise InputUnusable(
            f"a station runs on {settings.data_dir}; put a key of it with scope calibrate into "
            "STATION_KEY, of an installed one into /etc/treadline/credentials/key"
        )
    with StationClient.connect(url or _url(settings), key) as station:
        sensors = [sensor] if sensor is not None else station.calibrated_sensors()
        if not sensors:
            raise InputUnusable(
                "no sensor has a calibration in force; calibrate and activate one, or give "
                "--sensor ID"
            )
        return [station.recalibrate(sensor=name, timeout_s=timeout_s) for name in sensors]


def _url(settings: StationSettings) -> str:
    host = _ANYWHERE.get(settings.host, settings.host)
    scheme = "http" if settings.tls is None else "https"
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{settings.port}"


def _here(settings: StationSettings, sensor: str | None) -> list[Result]:
    # The answers' models are the API's, which nothing else on the command line needs.
    from station.api.recalibration_answers import RecalibrationModel  # noqa: PLC0415  see above

    log_as("recalibrate")  # to stderr, as stdout is the answer's
    rows = recalibrate_here(
        settings, sensor, new_id=lambda: uuid4().hex, say=lambda line: typer.echo(line, err=True)
    )
    return [RecalibrationModel.of(row).model_dump(mode="json") for row in rows]


def _text(result: Result) -> str:
    said = result["outcome"] or "not recalibrated"
    lines = [f"{result['sensor']}: {said.replace('_', ' ')}, {result['state']}"]
    lines += [f"  {reason}" for reason in result["reasons"]]
    if result["reason"]:
        lines.append(f"  {result['reason']}")
    if result["alarm"]:
        lines.append("  ALARM: the calibration in force may measure wrongly")
    return "\n".join(lines)


def _leave(results: Sequence[Result]) -> None:
    failed = [each["sensor"] for each in results if each["state"] == "failed"]
    if failed:
        raise InputUnusable(f"not recalibrated: {', '.join(failed)}; the reason stands above")
    asking = [
        f"{each['sensor']} (recalibration {each['id']})"
        for each in results
        if each["state"] == "asking" or each["alarm"]
    ]
    if asking:
        raise NothingMeasurable(f"somebody must look: {', '.join(asking)}")
