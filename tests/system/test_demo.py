"""The main job, whole: simulated cameras, Aravis, recordings, calibrations, readings, the API.

It does not show accuracy in every light; `test_lights.py` beside it does.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from second_pass import pass_again

QUANTITIES = ("tread_wear", "flange_thickness_10", "flange_thickness_12")
RIGS = ("left", "right")
PLACES = ("inner", "outer")
SHOWINGS, SHOTS = 16, 12


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return tmp_path_factory.mktemp("demo") / "kept"


@pytest.fixture(scope="module")
def demo(kept):
    command = [sys.executable, "-m", "station", "demo", "--out", str(kept), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=540, check=False)
    log = kept / "station.log"
    assert done.returncode == 0, done.stderr + (log.read_text() if log.exists() else "")
    return json.loads(done.stdout)


def test_no_frame_is_lost(demo):
    # Of four cameras, each in a session and in the pass.
    assert [account["lost"] for account in demo["frames"]] == [0] * 8
    assert all(account["recorded"] == account["triggered"] > 0 for account in demo["frames"])


def test_every_wheel_is_measured_once(demo):
    assert {wheel["reason"] for wheel in demo["wheels"]} == {None}
    wheels = [(wheel["rig"], wheel["axle"]) for wheel in demo["wheels"]]
    assert wheels == [(rig, axle) for rig in RIGS for axle in (1, 2, 3, 4)]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_readings_are_within_a_twentieth_of_a_millimetre_of_the_truth(demo, quantity):
    # What is asked of flange thickness by two sensors in good light. Measured: 0.02 mm.
    assert demo["rms_mm"][quantity] <= 0.05


def test_each_sensor_gives_the_part_of_the_profile_that_it_can_see(demo):
    for wheel in demo["wheels"]:
        inner, outer = (wheel["seen_mm"][f"{wheel['rig']}-{place}"] for place in PLACES)
        # The flange's shadow is between the two parts; the back is seen by the inner one alone.
        assert len(inner) == 2
        (from_back, to_tip), (from_shadow, _) = inner
        assert from_back < 1.0 < 15.0 < to_tip < 26.0
        assert 44.0 < from_shadow < 70.0
        assert 2.0 < outer[0][0] < 10.0
        assert any(low < 25.0 and high > 75.0 for low, high in outer)


def test_sensors_are_placed_right_to_each_other(demo):
    # Half of what flange thickness may be wrong by. Measured: 0.01 mm.
    assert max(rig["places_rms_mm"] for rig in demo["rigs"]) < 0.025


def test_joint_planes_are_nearer_the_truth_than_the_preplanar_ones(demo):
    # Over all sensors: dots that are 2 um off their places turn the frame of each camera a little,
    # by any method, and that may hide the difference at one.
    errors = {"joint": [], "preplanar": [], "deviation": []}
    for plane in demo["planes"]:
        errors[plane["method"]].append(plane["plane_rms_mm"])
    assert len(errors["joint"]) == len(RIGS) * len(PLACES)
    assert math.hypot(*errors["joint"]) < math.hypot(*errors["preplanar"])


def test_recordings_open_with_the_mcap_library_alone(demo, kept):
    recordings = sorted(kept.rglob("*.mcap"))
    assert len(recordings) == 8
    for path in recordings:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            topics = {channel.topic for channel in reader.get_summary().channels.values()}
            frames = sum(1 for _ in reader.iter_messages(topics=[f"/{path.stem}/image"]))
        assert f"/{path.stem}/image" in topics
        assert frames in {SHOWINGS, SHOTS}


OF_THE_PASS = {"time", "source", "axle", "side", "placing", "wheelset"}
"""When, what its recording is called, and which wheel of the train: no one recording says that."""


def readings(wheel):
    """Return all that was read off a wheel."""
    read = {name: value for name, value in wheel.items() if name not in OF_THE_PASS}
    backs = [{**back, "time": None} for back in wheel["standing"]["backs"]]
    return read | {"standing": {**wheel["standing"], "backs": backs}}


def live_readings(kept, rig):
    results = json.loads((kept / f"results-{rig}.json").read_text())
    return [readings(wheel) for wheel in results["wheels"]]


def recordings_of_pass(kept, rig):
    return {path.stem: path for path in kept.rglob(f"{rig}-*.mcap") if "passes" in path.parts}


@pytest.mark.parametrize("command", ["measure", "replay"])
def test_measuring_the_recordings_again_gives_what_the_station_read_bit_for_bit(
    demo, kept, tmp_path, command
):
    out = tmp_path / "results.json"
    sources = recordings_of_pass(kept, "left").values()
    words = [command, *sources, "--rig", kept / "rig-left.json", "--out", out]
    subprocess.run([sys.executable, "-m", "station", *words], check=True, capture_output=True)
    again = [readings(wheel) for wheel in json.loads(out.read_text())["wheels"]]
    assert again == live_readings(kept, "left")


def test_second_pass_before_cameras_that_show_the_first_is_read_the_same_bit_for_bit(demo, kept):
    recordings = {
        sensor: path for rig in RIGS for sensor, path in recordings_of_pass(kept, rig).items()
    }
    rows = pass_again(kept, "second-train", recordings)
    for rig in RIGS:
        again = [readings(row["wheel"]) for row in rows if row["sensor"] == rig]
        assert again == live_readings(kept, rig)


def test_folder_in_use_is_refused(demo, kept):
    command = [sys.executable, "-m", "station", "demo", "--out", str(kept)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
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
