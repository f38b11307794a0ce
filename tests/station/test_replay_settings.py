"""Shows where a station's cluster is named; what it does for a replay is shown with the worker."""

import json

import pytest

from station.cli.main import build_app, run
from station.errors import InputUnusable
from station.settings import load_settings

STATION = 'data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "station.toml"
    path.write_text(f'{STATION}[replay]\ncluster = "tls://10.0.0.5:8786"\n')
    return path


def test_without_a_table_a_station_measures_by_itself(config):
    config.write_text(STATION)
    assert load_settings(config).replay.cluster is None


def test_check_shows_the_cluster_and_explain_says_what_it_is(config, capsys):
    assert run(build_app("config"), ["config", "check", "--config", str(config), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["replay"] == {"cluster": "tls://10.0.0.5:8786"}
    assert run(build_app("config"), ["config", "explain", "--json"]) == 0
    (told,) = (
        each
        for each in json.loads(capsys.readouterr().out)["settings"]
        if each["name"] == "replay.cluster"
    )
    assert "Dask cluster" in told["meaning"]


@pytest.mark.parametrize("address", ["10.0.0.5:8786", "tcp://10.0.0.5", "http://h:1", ""])
def test_what_is_no_address_of_a_scheduler_is_one_line_that_names_it(config, address):
    config.write_text(f'{STATION}[replay]\ncluster = "{address}"\n')
    with pytest.raises(InputUnusable, match="not the address of a Dask scheduler") as refused:
        load_settings(config)
    assert "\n" not in str(refused.value)
    assert repr(address) in str(refused.value)


def test_the_example_for_the_track_names_a_cluster_that_can_be_turned_on(tmp_path, request):
    example = (request.config.rootpath / "deploy" / "station.toml").read_text()
    assert load_settings(write(tmp_path, example)).replay.cluster is None
    on = example.replace("# [replay]", "[replay]").replace("# cluster =", "cluster =")
    assert load_settings(write(tmp_path, on)).replay.cluster == "tls://10.0.0.5:8786"


def write(folder, text):
    path = folder / "example.toml"
    path.write_text(text)
    return path
