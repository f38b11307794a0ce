"""The main job, whole: simulated cameras, Aravis, recordings, calibrations, readings, the API.

It does not show accuracy in every light; `test_lights.py` beside it does.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from second_pass import pass_again

QUANTITIES = ("tread_wear", "flange_thickness_10", "flange_thickness_12")


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return tmp_path_factory.mktemp("demo") / "kept"


@pytest.fixture(scope="module")
def demo(kept):
    command = [sys.executable, "-m", "station", "demo", "--out", str(kept), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
    log = kept / "station.log"
    assert done.returncode == 0, done.stderr + (log.read_text() if log.exists() else "")
    return json.loads(done.stdout)


def test_no_frame_is_lost(demo):
    assert [account["lost"] for account in demo["frames"]] == [0] * 4
    assert all(account["recorded"] == account["triggered"] > 0 for account in demo["frames"])


def test_every_wheel_is_measured_by_every_method(demo):
    assert {wheel["reason"] for wheel in demo["wheels"]} == {None}
    for method in {plane["method"] for plane in demo["planes"]}:
        assert len([wheel for wheel in demo["wheels"] if wheel["method"] == method]) == 8


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_readings_are_within_a_tenth_of_a_millimetre_of_the_truth(demo, quantity):
    # What a type-4 wheel gauge is trusted with.
    assert demo["rms_mm"]["joint"][quantity] <= 0.10


def test_joint_plane_is_nearer_the_truth_than_the_preplanar_one(demo):
    error = {(p["sensor"], p["method"]): p["plane_rms_mm"] for p in demo["planes"]}
    for sensor in {sensor for sensor, _ in error}:
        assert error[sensor, "joint"] < error[sensor, "preplanar"]


def test_recordings_open_with_the_mcap_library_alone(demo, kept):
    recordings = sorted(kept.rglob("*.mcap"))
    assert len(recordings) == 4
    for path in recordings:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            topics = {channel.topic for channel in reader.get_summary().channels.values()}
            frames = sum(1 for _ in reader.iter_messages(topics=[f"/{path.stem}/image"]))
        assert f"/{path.stem}/image" in topics
        assert frames in {20, 12}


OF_THE_PASS = {"time", "source", "axle", "side", "placing", "wheelset"}
"""When, what its recording is called, and which wheel of the train: no one recording says that."""


def readings(wheel):
    """Return all that was read off a wheel."""
    return {name: value for name, value in wheel.items() if name not in OF_THE_PASS}


def live_readings(kept, sensor):
    results = json.loads((kept / f"results-{sensor}-joint.json").read_text())
    return [readings(wheel) for wheel in results["wheels"]]


def recording_of_pass(kept, sensor):
    (path,) = (path for path in kept.rglob(f"{sensor}.mcap") if "passes" in path.parts)
    return path


@pytest.mark.parametrize("command", ["measure", "replay"])
def test_measuring_a_recording_again_gives_what_the_station_read_bit_for_bit(
    demo, kept, tmp_path, command
):
    out = tmp_path / "results.json"
    calibration = kept / "calibration-left-joint.json"
    words = [command, recording_of_pass(kept, "left"), "--calibration", calibration, "--out", out]
    subprocess.run([sys.executable, "-m", "station", *words], check=True, capture_output=True)
    again = [readings(wheel) for wheel in json.loads(out.read_text())["wheels"]]
    assert again == live_readings(kept, "left")


def test_second_pass_before_cameras_that_play_the_first_is_read_the_same_bit_for_bit(demo, kept):
    recordings = {sensor: recording_of_pass(kept, sensor) for sensor in ("left", "right")}
    rows = pass_again(kept, "second-train", recordings)
    for sensor in recordings:
        again = [readings(row["wheel"]) for row in rows if row["sensor"] == sensor]
        assert again == live_readings(kept, sensor)


def test_folder_in_use_is_refused(demo, kept):
    command = [sys.executable, "-m", "station", "demo", "--out", str(kept)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "not empty" in done.stderr


def test_nothing_is_left_running_or_lying_about(demo, kept):
    assert not _processes_running_on(kept)
    assert not list(Path("/dev/shm").glob("treadline*"))


def _processes_running_on(folder):
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                command = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if str(folder).encode() in command:
                found.append(entry.name)
    return found
