"""`station camera simulate` and `list`, run as a user runs them."""

import json
import signal
import subprocess
import sys

import cv2
import pytest
from aravis_receiver import Receiver
from simulated_pictures import numbered_pictures, numbered_source

from station.cli.main import build_app, run
from station.simulated import SimulatedCamera

PICTURES = numbered_pictures(2, 320, 200)


@pytest.fixture
def folder(tmp_path):
    for number, picture in enumerate(PICTURES):
        cv2.imwrite(str(tmp_path / f"{number}.png"), picture)
    return tmp_path


def station(*arguments):
    return run(build_app("camera"), ["camera", *map(str, arguments)])


def start_simulation(*arguments):
    command = "from station.cli import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", command, "camera", "simulate", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_simulation_says_when_it_is_ready_and_ends_on_sigterm(folder):
    process = start_simulation("--address", "127.10.6.1", "--pictures", folder, "--serial", "T1")
    with process:
        ready = process.stdout.readline()
        assert ready.startswith("camera T1 at 127.10.6.1: 320 × 200 px")
        receiver = Receiver("127.10.6.1")
        with receiver:
            assert receiver.next().data == PICTURES[0].tobytes()
        receiver.close()
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "pictures taken" in out
    assert not err


def test_a_simulation_raises_line1_in_its_rhythm(folder):
    process = start_simulation(
        "--address", "127.10.6.2", "--pictures", folder, "--line1-hz", 50, "--json"
    )
    with process:
        assert "127.10.6.2" in process.stderr.readline()
        receiver = Receiver("127.10.6.2")
        receiver.camera.set_trigger("Line1")
        with receiver:
            times = [frame.timestamp_ns for frame in receiver.take(5)]
        receiver.close()
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
    steps = [later - earlier for earlier, later in zip(times, times[1:], strict=False)]
    # Each is k * 20 ms rounded to whole ns.
    assert all(abs(step - 20_000_000) <= 1 for step in steps)
    statistics = json.loads(out)
    assert statistics["sent"] >= 5
    assert statistics["missed_triggers"] > 0


def test_a_simulation_ends_after_its_seconds(folder, capsys):
    arguments = ["--address", "127.10.6.3", "--pictures", folder, "--seconds", 0.1, "--json"]
    assert station("simulate", *arguments) == 0
    assert json.loads(capsys.readouterr().out)["exposed"] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--address", "10.255.255.254"], "no address of this host"),
        (["--address", "127.10.6.9"], "in use"),
        (["--address", "nowhere"], "no IPv4 address"),
        (["--address", "127.10.6.4", "--packet-loss", "2"], "packet-loss"),
        (["--address", "127.10.6.4", "--scene", "wheel"], "one thing"),
    ],
)
def test_what_cannot_be_simulated_is_one_line_and_exit_2(folder, capsys, arguments, message):
    with SimulatedCamera("127.10.6.9", numbered_source(1, 64, 48)):
        assert station("simulate", "--pictures", folder, *arguments) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("option", ["--pictures", "--from"])
def test_a_source_that_is_not_there_is_one_line_and_exit_2(tmp_path, capsys, option):
    missing = tmp_path / "none.mcap"
    assert station("simulate", "--address", "127.10.6.5", option, missing) == 2
    err = capsys.readouterr().err
    assert "none.mcap" in err
    assert err.count("\n") == 1


def test_the_list_shows_cameras_found_and_asked_for(capsys):
    with (
        SimulatedCamera("127.10.6.6", numbered_source(1, 64, 48), serial="LIST-1"),
        SimulatedCamera("127.10.6.7", numbered_source(1, 64, 48), serial="LIST-2"),
    ):
        assert station("list", "--json", "--address", "127.10.6.7") == 0
        listed = {camera["address"]: camera for camera in json.loads(capsys.readouterr().out)}
        assert listed["127.10.6.6"]["serial"] == "LIST-1"
        assert listed["127.10.6.7"]["vendor"] == "Treadline"
        assert station("list") == 0
        assert "127.10.6.6  LIST-1  Treadline Simulated NIR camera\n" in capsys.readouterr().out


def test_an_address_that_does_not_answer_is_one_line_and_exit_2(capsys):
    assert station("list", "--address", "127.10.6.8") == 2
    assert "no camera answers at 127.10.6.8" in capsys.readouterr().err
