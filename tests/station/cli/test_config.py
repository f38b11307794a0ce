"""`station config`: what is fit to start with, what every setting means; not that it starts."""

import json
from pathlib import Path

import pytest
from pydantic import BaseModel

from station.cli.config_explained import explained
from station.cli.main import build_app, run
from station.errors import InputUnusable
from station.settings import StationSettings, credential, load_settings

EXAMPLE = Path("deploy/station.toml")
SECRET_URL = "postgresql://station:hush@db/station"


def check(*arguments):
    return run(build_app("config"), ["config", "check", *map(str, arguments)])


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "station.toml"
    path.write_text('data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n')
    return path


def test_the_settings_that_come_with_the_package_are_fit(capsys):
    assert check("--config", EXAMPLE, "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["sensors"][0]["id"] == "left"
    assert shown["limits"]["preset"] == "practice"


def test_a_setting_that_is_none_is_named(config, capsys):
    config.write_text(config.read_text() + "speed = 3\n")
    assert check("--config", config) == 2
    assert "speed" in capsys.readouterr().err


def test_a_data_folder_that_cannot_be_made_is_refused(config, capsys):
    config.write_text(config.read_text().replace('"data"', '"station.toml/data"'))
    assert check("--config", config) == 2
    assert "station.toml cannot be written to" in capsys.readouterr().err


def test_a_certificate_that_is_not_there_is_refused(config, capsys):
    config.write_text(config.read_text() + '[tls]\ncertificate = "a.pem"\nkey = "a.key"\n')
    assert check("--config", config) == 2
    assert "a.pem" in capsys.readouterr().err


def test_the_password_of_the_store_is_not_shown(config, capsys, monkeypatch):
    monkeypatch.setenv("STATION_STORE_URL", SECRET_URL)
    assert check("--config", config, "--json") == 0
    out = capsys.readouterr().out
    assert "hush" not in out
    assert json.loads(out)["store_url"] == "(hidden)"


def test_every_setting_is_explained():
    settings = list(explained(StationSettings))
    names = [each["name"] for each in settings]
    assert [each["name"] for each in settings if not each["meaning"]] == []
    assert len(names) == len(set(names))
    assert "sensors[].mounting.translation_mm" in names
    assert "recalibration.sensors.NAME.piece.certificate" in names


def test_a_setting_without_a_meaning_would_be_seen():
    class Mute(BaseModel):
        speed: float

    assert [each["meaning"] for each in explained(Mute)] == [""]


def test_secrets_come_from_the_folder_of_the_service(config, tmp_path, monkeypatch):
    folder = tmp_path / "credentials"
    folder.mkdir()
    (folder / "station_store_url").write_text(f"{SECRET_URL}\n")
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(folder))
    monkeypatch.delenv("STATION_STORE_URL", raising=False)
    assert load_settings(config).store_url == SECRET_URL


def test_the_environment_comes_before_the_folder(tmp_path):
    (tmp_path / "station_key").write_text("of the folder")
    environment = {"CREDENTIALS_DIRECTORY": str(tmp_path), "STATION_KEY": "of the environment"}
    assert credential("key", environment=environment) == "of the environment"
    assert (
        credential("key", environment={"CREDENTIALS_DIRECTORY": str(tmp_path)}) == "of the folder"
    )
    assert credential("admin_key", environment=environment) is None


def test_an_empty_secret_is_refused(tmp_path):
    (tmp_path / "station_key").write_text("\n")
    with pytest.raises(InputUnusable, match="credential key: its file is empty"):
        credential("key", environment={"CREDENTIALS_DIRECTORY": str(tmp_path)})


def test_a_secret_that_cannot_be_read_is_named(tmp_path):
    (tmp_path / "station_key").mkdir()
    with pytest.raises(InputUnusable, match="credential key: cannot be read"):
        credential("key", environment={"CREDENTIALS_DIRECTORY": str(tmp_path)})


def test_a_folder_of_secrets_that_cannot_be_entered_is_said(tmp_path):
    (tmp_path / "folder").write_text("not one")
    with pytest.raises(InputUnusable, match="credential key: cannot be read"):
        credential("key", environment={"CREDENTIALS_DIRECTORY": str(tmp_path / "folder")})


def test_who_types_a_command_has_the_secrets_beside_the_settings(config, monkeypatch):
    for name in ("STATION_STORE_URL", "CREDENTIALS_DIRECTORY"):
        monkeypatch.delenv(name, raising=False)
    folder = config.parent / "credentials"
    folder.mkdir()
    before = load_settings(config).store_url
    (folder / "store_url").write_text(f"{SECRET_URL}\n")
    assert before is None
    assert load_settings(config).store_url == SECRET_URL
    of_service = {"CREDENTIALS_DIRECTORY": str(config.parent / "none")}
    assert credential("store_url", config, of_service) is None


def test_a_secret_that_is_not_for_this_user_is_refused_and_not_overlooked(config, monkeypatch):
    def refuse(path, **_):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_text", refuse)
    with pytest.raises(InputUnusable, match="may not be read by this user; type it as root, or"):
        credential("store_url", config, {})


def test_who_may_not_read_the_fleets_secret_loads_the_settings_all_the_same(config, monkeypatch):
    """An upgrade has the station's user back up the store: the fleet is none of its business."""
    for name in ("STATION_FLEET_URL", "CREDENTIALS_DIRECTORY"):
        monkeypatch.delenv(name, raising=False)
    config.write_text(config.read_text() + '[fleet]\nurl = "sqlite:////fleet.sqlite"\n')
    (config.parent / "credentials" / "fleet_url").mkdir(parents=True)  # whoever reads it fails
    with pytest.raises(InputUnusable, match="credential fleet_url: cannot be read"):
        credential("fleet_url", config)
    fleet = load_settings(config).fleet
    assert fleet is not None
    assert fleet.url == "sqlite:////fleet.sqlite"
