"""Mistakes a user makes, typed at the command line: exit 2 and one line that helps."""

import socket
import subprocess
import sys

import cv2
import numpy as np
import pytest

from calib import Target
from station.scenes import Light, paper_sensor, target_scenes

TARGET = "dots:7x8:12:d=6"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("input")
    rng = np.random.default_rng(5)
    (scene,) = target_scenes(rng, paper_sensor(), Target.parse(TARGET), [Light.GOOD])
    (folder / "one").mkdir()
    cv2.imwrite(str(folder / "one" / "pose.png"), scene.render(rng))
    (folder / "nothing").mkdir()
    noise = rng.integers(0, 40, (200, 300), dtype=np.uint8)
    for name in ("a", "b", "c"):
        cv2.imwrite(str(folder / "nothing" / f"{name}.png"), noise)
    (folder / "text.png").write_text("no picture")
    (folder / "text.mcap").write_text("no recording")
    (folder / "empty.mcap").write_bytes(b"")
    return folder


def station(*arguments):
    command = [sys.executable, "-m", "station", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def refused(done):
    assert done.returncode == 2, (done.stdout, done.stderr)
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("station: ")
    assert not done.stdout
    return done.stderr


@pytest.mark.parametrize(
    ("source", "target", "said"),
    [
        ("absent.png", TARGET, "no such file"),
        ("text.png", TARGET, "no whole picture"),
        ("absent.mcap", TARGET, "No such file"),
        ("text.mcap", TARGET, "text.mcap"),
        ("empty.mcap", TARGET, "empty.mcap"),
        ("nothing", TARGET, "target"),
        ("one", TARGET, "1 "),
        ("one", "dots:7by8", "allowed: dots:ROWSxCOLS"),
        ("one", "dots:1x1:12", "allowed"),
    ],
)
def test_calibrate_says_what_is_wrong_with_its_input(folder, tmp_path, source, target, said):
    out = tmp_path / "calibration.json"
    message = refused(station("calibrate", folder / source, "--target", target, "--out", out))
    assert said in message
    assert not out.exists()


def test_measure_says_that_the_calibration_is_none(folder):
    message = refused(station("measure", folder / "one", "--calibration", folder / "text.png"))
    assert "CalibrationDocument" in message


def test_record_says_that_no_camera_answers(tmp_path):
    out = tmp_path / "out.mcap"
    message = refused(station("record", "--camera", "127.99.99.99", "--out", out, "--frames", "1"))
    assert "127.99.99.99" in message
    assert list(tmp_path.iterdir()) == []


def test_serve_says_that_the_port_is_in_use(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        config = tmp_path / "station.toml"
        config.write_text(
            f'data_dir = "{tmp_path / "data"}"\nport = {port}\n'
            '[[sensors]]\nid = "left"\naddress = "127.0.0.1"\n'
        )
        message = refused(station("serve", "--config", config))
    assert str(port) in message
    assert "in use" in message


def test_simulate_says_that_the_address_is_in_use(folder):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.99.99.98", 3956))
        message = refused(
            station("camera", "simulate", "--address", "127.99.99.98", "--pictures", folder / "one")
        )
    assert "127.99.99.98" in message
