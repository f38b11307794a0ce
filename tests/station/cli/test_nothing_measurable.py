"""Pictures on which no wheel can be measured, through `station measure`, from file to exit code.

Each is one picture and, three times over, the pictures of one wheel in a recording. What else a
picture of no wheel may hold (specks, lines) is shown on stripes in the tests of `measure`.
"""

import json

import cv2
import numpy as np
import pytest
from wheel_recordings import record, true_calibration

from measure import Quantity
from station.cli.main import build_app, run
from station.scenes import RailScene, WheelScene, WheelTruth, paper_sensor, trackside_mounting

FRAMES = 3
WORN = WheelTruth("S1002", tread_wear_mm=2.0, flange_wear_mm=1.0)


def wheel(**changes):
    return WheelScene(paper_sensor(), trackside_mounting("left"), WORN, seed=4, **changes)


def seen(scene, *, exposure=1.0):
    return scene.render(np.random.default_rng(5), exposure)


CASES = {
    "dark": (lambda: seen(wheel(), exposure=0.01), "no stripe"),
    "laser off": (lambda: seen(wheel(laser_on=False)), "no stripe"),
    "no wheel": (lambda: seen(wheel(axle_offset_mm=-900.0)), "no stripe"),
    # Cut by the edge of the picture: before the tape circle, and through the flange.
    "half a wheel, flange": (lambda: seen(wheel(lateral_shift_mm=245.0)), "half a wheel"),
    "half a wheel, tread": (lambda: seen(wheel(lateral_shift_mm=-160.0)), "half a wheel"),
    "two wheels": (
        lambda: seen(wheel(lateral_shift_mm=-80.0, neighbours_mm=(160.0,))),
        "two wheels",
    ),
    "upside down": (lambda: np.ascontiguousarray(seen(wheel())[::-1, ::-1]), "no wheel"),
    "rail only": (
        lambda: seen(RailScene(paper_sensor(), trackside_mounting("left"), seed=4)),
        "no wheel",
    ),
}


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    path = tmp_path_factory.mktemp("calibration") / "calibration.json"
    true_calibration().write(path)
    return path


@pytest.fixture(scope="module")
def pictures():
    return {name: draw() for name, (draw, _) in CASES.items()}


@pytest.fixture
def measured(calibration, tmp_path, capsys):
    """Return a function: exit code, the document, the document written, what stderr says."""

    def do(source):
        out = tmp_path / "results.json"
        code = run(
            build_app(),
            [
                *("measure", str(source), "--calibration", str(calibration)),
                *("--out", str(out), "--json"),
            ],
        )
        printed, said = capsys.readouterr()
        return code, json.loads(printed), json.loads(out.read_text()), said

    return do


def assert_nothing(answer, reason):
    code, printed, written, said = answer
    assert code == 1
    assert printed == written
    (row,) = printed["wheels"]
    assert reason in row["reason"]
    # One line: how many, and every reason once.
    assert said.count("\n") == 1
    assert row["reason"] in said
    assert row["profile"] is None
    for quantity in Quantity:
        reading = row[quantity.value]
        assert reading["value"] is reading["u95"] is None
        assert reading["status"] == "missing"
        assert reading["alarm"] == "unknown"
    return row


@pytest.mark.parametrize("name", CASES)
def test_picture_of_no_wheel_is_a_row_with_a_reason_and_exit_1(name, pictures, measured, tmp_path):
    path = tmp_path / "picture.png"
    cv2.imwrite(str(path), pictures[name])
    row = assert_nothing(measured(path), CASES[name][1])
    assert row["source"].endswith("picture.png")


@pytest.mark.parametrize("name", CASES)
def test_three_frames_of_no_wheel_are_one_row_that_counts_them(name, pictures, measured, tmp_path):
    (path,) = record(tmp_path / "pass.mcap", [[pictures[name]] * FRAMES])
    row = assert_nothing(measured(path), CASES[name][1])
    assert row["frames"] == [1, 2, 3]
    assert len(row["quality"]["unmeasured"]) == FRAMES


def test_a_wheel_among_nothing_is_measured_and_the_rest_keep_their_rows(
    pictures, measured, tmp_path
):
    order = ("dark", "good", "rail only")
    views = {"good": seen(wheel()), **pictures}
    (path,) = record(tmp_path / "pass.mcap", [[views[name]] * FRAMES for name in order])
    code, printed, _, said = measured(path)
    assert (code, said) == (0, "")
    reasons = [row["reason"] for row in printed["wheels"]]
    assert "no stripe" in reasons[0]
    assert reasons[1] is None
    assert "no wheel" in reasons[2]
    # Said of itself, not of its neighbours: the one wheel is 2 mm worn.
    assert printed["wheels"][1]["tread_wear"]["value"] == pytest.approx(2.0, abs=0.06)


def test_frames_that_show_nothing_do_not_take_part_in_a_wheel(pictures, measured, tmp_path):
    views = [pictures["rail only"], seen(wheel()), pictures["half a wheel, tread"]]
    (path,) = record(tmp_path / "pass.mcap", [views])
    code, printed, _, _ = measured(path)
    assert code == 0
    (row,) = printed["wheels"]
    assert row["quality"]["frames_used"] == [2]
    assert sorted(row["quality"]["unmeasured"]) == ["1", "3"]
    assert row["frame"] == 2
