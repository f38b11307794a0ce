"""What the README shows is what there is: its settings load, its commands and options exist."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest

from station.cli.main import COMMANDS, GROUPS, build_app, run
from station.settings import load_settings

README = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")
SHOWN = [
    shlex.split(line.partition(" #")[0])[1:]
    for block in re.findall(r"```sh[^\n]*\n(.*?)```", README, re.DOTALL)
    for line in block.replace("\\\n", "").splitlines()
    if line.startswith("station ")
]


TABLES = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)


def test_settings_shown_load(tmp_path):
    (tmp_path / "station.toml").write_text(TABLES[0])
    settings = load_settings(tmp_path / "station.toml")
    assert settings.sensor("left").mounting is not None


@pytest.mark.parametrize("text", TABLES[1:])
def test_tables_shown_load_in_a_station_that_has_their_sensors(tmp_path, text):
    told = tomllib.loads(text)
    names = [name for rig in told.get("rigs", ()) for name in rig["sensors"]] or ["left"]
    sensors = [
        f'[[sensors]]\nid = "{name}"\naddress = "192.168.10.{place}"\n'
        for place, name in enumerate(names, start=2)
    ]
    (tmp_path / "station.toml").write_text("\n".join(['data_dir = "data"', *sensors, text]))
    settings = load_settings(tmp_path / "station.toml")
    assert all(getattr(settings, name) for name in told)


@pytest.mark.parametrize("words", SHOWN, ids=" ".join)
def test_command_shown_exists_with_its_options(capsys, words):
    name = words[0]
    assert name in {*COMMANDS, *GROUPS}
    path = words[:2] if name in GROUPS else words[:1]
    assert run(build_app(name), [*path, "--help"]) == 0
    described = capsys.readouterr().out
    assert all(word in described for word in words if word.startswith("--"))
