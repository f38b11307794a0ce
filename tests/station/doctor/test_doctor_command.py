"""The command on this very host: exit codes, one document, every cure where something is wrong."""

import json
import time

import pytest

from station.cli.main import build_app, run
from station.doctor import disk, examine
from station.simulated import ArraySource, SimulatedCamera

CONFIG = """
data_dir = "data"
[[sensors]]
id = "left"
address = "{address}"
frame_rate_hz = 5.0
ring_slots = 8
"""
_SMALL_TRIAL = 16 << 20


@pytest.fixture(autouse=True)
def short_trial(monkeypatch):
    fully = disk.write_speed
    monkeypatch.setattr(disk, "write_speed", lambda folder: fully(folder, size_bytes=_SMALL_TRIAL))


@pytest.fixture
def kept_clock(monkeypatch):
    state = examine.__globals__["clock"].ClockState(synchronised=True, largest_error_s=0.01)
    monkeypatch.setattr("station.doctor.clock.clock_state", lambda: state)


def config_at(folder, address):
    path = folder / "station.toml"
    path.write_text(CONFIG.format(address=address))
    return path


def doctor(*arguments):
    return run(build_app("doctor"), ["doctor", *map(str, arguments)])


def findings(capsys):
    document = json.loads(capsys.readouterr().out)
    return document, {finding["name"]: finding for finding in document["findings"]}


def test_a_camera_that_answers_is_fine_and_one_that_does_not_is_exit_1(
    tmp_path, capsys, rng, kept_clock
):
    address = "127.40.1.1"
    path = config_at(tmp_path, address)
    source = ArraySource([rng.integers(0, 255, (48, 64), dtype="uint8")])
    with SimulatedCamera(address, source):
        doctor("--config", path, "--json")
        _, with_camera = findings(capsys)
    assert doctor("--config", path, "--json") == 1
    document, without = findings(capsys)
    assert with_camera["camera left"]["fine"]
    assert with_camera["packets of left"]["fine"]
    assert not without["camera left"]["fine"]
    assert not document["fine"]
    assert all((finding["cure"] is None) == finding["fine"] for finding in without.values())


def test_without_settings_the_host_alone_is_judged(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    began_s = time.monotonic()
    doctor("--json")
    _, found = findings(capsys)
    assert {"receive buffer", "backlog", "clock", "disk speed", "free space", "Aravis"} <= set(
        found
    )
    assert not any("camera" in name for name in found)
    assert time.monotonic() - began_s < 60.0


def test_what_is_wrong_is_one_line_on_stderr(tmp_path, capsys):
    assert doctor("--config", config_at(tmp_path, "127.40.1.2")) == 1
    out, err = capsys.readouterr()
    assert err.count("\n") == 1
    assert "camera left" in err
    assert "LOSES camera left" in out


@pytest.mark.parametrize("address", ["nowhere", "127.0.0"])
def test_an_address_that_is_none_is_exit_2(tmp_path, capsys, address):
    assert doctor("--config", config_at(tmp_path, address)) == 2
    assert "not an IPv4 address" in capsys.readouterr().err


def test_settings_that_are_missing_are_exit_2(tmp_path, capsys):
    assert doctor("--config", tmp_path / "none.toml") == 2
    assert capsys.readouterr().err.count("\n") == 1
