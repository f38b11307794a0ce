"""Shows where a station's fleet is named, and that its password is shown to nobody."""

import json

import pytest

from station.cli.main import build_app, run
from station.errors import InputUnusable
from station.settings import load_settings

SECRET = "postgresql://north:hush@fleet.example/fleet"
SENSOR = '[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.delenv("STATION_FLEET_URL", raising=False)
    path = tmp_path / "station.toml"
    path.write_text(f'data_dir = "data"\n{SENSOR}[fleet]\nurl = "{SECRET}"\nstation = "north"\n')
    return path


def test_without_a_table_a_station_stands_alone(config):
    config.write_text(f'data_dir = "data"\n{SENSOR}')
    assert load_settings(config).fleet is None


def test_the_environment_and_the_credentials_come_before_the_file(config, tmp_path, monkeypatch):
    assert load_settings(config).fleet.url == SECRET
    folder = tmp_path / "credentials"
    folder.mkdir()
    (folder / "station_fleet_url").write_text("postgresql://a@b/of-the-folder\n")
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(folder))
    assert load_settings(config).fleet.url.endswith("of-the-folder")
    monkeypatch.setenv("STATION_FLEET_URL", "postgresql://a@b/of-the-environment")
    assert load_settings(config).fleet.url.endswith("of-the-environment")


def test_the_password_is_not_shown(config, capsys):
    assert run(build_app("config"), ["config", "check", "--config", str(config), "--json"]) == 0
    out = capsys.readouterr().out
    assert "hush" not in out
    assert json.loads(out)["fleet"]["url"] == "(hidden)"
    assert "hush" not in repr(load_settings(config))


@pytest.mark.parametrize(
    "line", ['station = "two words"', "every_s = 0", "alarm_after_days = -1", "speed = 3"]
)
def test_a_setting_that_is_not_allowed_is_named(config, line):
    name = line.partition(" ")[0]
    text = config.read_text().replace('station = "north"\n', "")
    config.write_text(f"{text}{line}\n")
    with pytest.raises(InputUnusable, match=f"fleet.{name}"):
        load_settings(config)
