"""Recordings of several sensors become the axles of one train; misfits are refused."""

import json

import pytest
from wheel_recordings import record, true_calibration

from measure import Side
from station.cli.main import build_app, run
from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.pipeline import measure_train

SIDES = {"left": Side.LEFT, "right": Side.RIGHT}


@pytest.fixture(scope="module")
def train(tmp_path_factory, views):
    """Three axles; the right sensor's recording ends before the last."""
    folder = tmp_path_factory.mktemp("train")
    for sensor, count in (("left", 3), ("right", 2)):
        record(folder / f"{sensor}.mcap", [views[:1]] * count, sensor=sensor)
        true_calibration(sensor).write(folder / f"{sensor}.json")
    return folder


def rows(document):
    return [(wheel.axle, wheel.side, wheel.reason is None) for wheel in document.wheels]


def test_recordings_of_both_sides_are_measured_axle_for_axle(train):
    document = measure_train(
        [train / "left.mcap", train / "right.mcap"],
        [true_calibration("right"), true_calibration("left")],
        sides=SIDES,
        counted=3,
    )
    assert rows(document) == [
        (1, "left", True),
        (1, "right", True),
        (2, "left", True),
        (2, "right", True),
        (3, "left", True),
        (3, "right", False),
    ]
    missed = document.wheels[-1]
    assert missed.reason == "not seen: sensor right: no frame of this axle"
    assert {wheel.placing for wheel in document.wheels} == {"certain"}
    for wheel in document.wheels:
        fingerprint = true_calibration(wheel.sensor).fingerprint
        assert document.calibration_of(wheel) == fingerprint


def command(train, *more):
    calibrations = [f"--calibration={train / f'{sensor}.json'}" for sensor in SIDES]
    return ["measure", *map(str, more), *calibrations]


def test_the_command_names_axle_and_side_and_writes_both(train, tmp_path, capsys):
    out = tmp_path / "results.json"
    both = [train / "left.mcap", train / "right.mcap"]
    assert run(build_app("measure"), command(train, *both, "--axles=3", f"--out={out}")) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("axle 1 left, left.mcap frame 1: flange_height")
    assert lines[5] == "axle 3 right: not measured: not seen: sensor right: no frame of this axle"
    assert lines[6].startswith("no back-to-back: measured without [track], which says how")
    assert lines[7:] == ["5 of 6 wheels measured"]
    assert rows(MeasurementDocument.read(out))[-1] == (3, "right", False)
    assert json.loads(out.read_text())["wheels"][0]["placing"] == "certain"


def test_without_a_count_the_lines_say_that_numbers_are_inferred(train, capsys):
    both = [train / "left.mcap", train / "right.mcap"]
    assert run(build_app("measure"), command(train, *both)) == 0
    assert capsys.readouterr().out.startswith("axle 1 left (inferred), left.mcap frame 1:")


@pytest.mark.parametrize(
    ("sources", "calibrations", "sides", "says"),
    [
        (["left.mcap", "left.mcap"], ["left", "right"], SIDES, "are both of sensor left"),
        (["left.mcap"], ["right", "other"], SIDES, "but the calibrations are of right, other"),
        (["left.mcap"], ["left", "right"], {}, "the side of sensor left is not known"),
        (["left.mcap"], ["left", "left"], SIDES, "two calibrations of one sensor"),
        ([], ["left", "right"], SIDES, "no SOURCE given"),
    ],
)
def test_what_is_no_pass_of_several_sensors_is_refused(train, sources, calibrations, sides, says):
    with pytest.raises(InputUnusable, match=says):
        measure_train(
            [train / name for name in sources],
            [true_calibration(name) for name in calibrations],
            sides=sides,
        )


def test_two_passes_of_one_sensor_are_no_train(train, tmp_path, views):
    record(tmp_path / "later.mcap", [views[:1]], sensor="left")
    with pytest.raises(InputUnusable, match="both of sensor left; give one recording"):
        measure_train(
            [train / "left.mcap", tmp_path / "later.mcap"],
            [true_calibration("left"), true_calibration("right")],
            sides=SIDES,
        )


def test_a_count_of_axles_needs_both_sides(train, capsys):
    one = ["measure", str(train / "left.mcap"), f"--calibration={train / 'left.json'}"]
    assert run(build_app("measure"), [*one, "--axles=3"]) == 2
    assert "--axles is of a train" in capsys.readouterr().err
