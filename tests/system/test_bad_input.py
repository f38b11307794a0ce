"""Mistakes a user makes, typed at the command line: exit 2 and one line that helps.

Those of `serve` and `record` are shown beside what these do.
"""

import json
import socket
import subprocess
import sys

import cv2
import numpy as np
import pytest

from calib import Target, calibrate
from station.bench.simulation import HEIGHT_PX, SENSOR, WIDTH_PX, Noise, Simulation
from station.bench.simulation import TARGET as BOARD
from station.cli.main import build_app, run
from station.documents import CameraDocument, points_csv
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


def in_a_process(*arguments):
    """What the command says, started as a user starts it."""
    command = [sys.executable, "-m", "station", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.fixture
def station(capfd):
    """The command in this process: starting another one takes longer than all the rest.

    What a library of C says by itself is heard, too.
    """

    def station(*arguments):
        words = [str(word) for word in arguments]
        code = run(build_app(words[0]), words)
        said = capfd.readouterr()
        return subprocess.CompletedProcess(words, code, said.out, said.err)

    return station


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
def test_calibrate_says_what_is_wrong_with_its_input(
    station, folder, tmp_path, source, target, said
):
    out = tmp_path / "calibration.json"
    message = refused(station("calibrate", folder / source, "--target", target, "--out", out))
    assert said in message
    assert not out.exists()


POINTS_TARGET = "dots:10x10:10"


def edited(place, text):
    """An edit of the rows: field `place` of the fifth becomes `text`."""

    def edit(rows):
        rows[4][place] = text
        return rows

    return edit


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    """Rows of a good points.csv, and the folder with the camera's file."""
    folder = tmp_path_factory.mktemp("points")
    CameraDocument.from_model(SENSOR.camera).write(folder / "camera.json")
    drawn = Simulation.drawn(6, 3).noisy(np.random.default_rng(4), Noise(0.05, 0.05))
    found = calibrate(drawn.views, BOARD, width=WIDTH_PX, height=HEIGHT_PX, camera=SENSOR.camera)
    return folder, [line.split(",") for line in points_csv(found).splitlines()]


@pytest.fixture
def calibrated(points, tmp_path, station):
    """What the command says of edited rows, and the file it was told to write."""
    folder, rows = points

    def run_on(edit, target=POINTS_TARGET):
        path, out = tmp_path / "points.csv", tmp_path / "calibration.json"
        path.write_text("".join(",".join(row) + "\n" for row in edit([list(row) for row in rows])))
        words = ["calibrate", path, "--target", target, "--camera", folder / "camera.json"]
        return station(*words, "--out", out), out

    return run_on


@pytest.mark.parametrize(
    ("edit", "target", "said"),
    [
        (edited(4, "nan"), POINTS_TARGET, "line 5: a coordinate or sigma that is not finite"),
        (edited(4, "inf"), POINTS_TARGET, "line 5: a coordinate or sigma that is not finite"),
        (edited(4, "9000"), POINTS_TARGET, "a point at 9000"),
        (edited(6, "0"), POINTS_TARGET, "line 5: sigma 0"),
        (edited(6, "-1"), POINTS_TARGET, "line 5: sigma -1"),
        (edited(1, "blob"), POINTS_TARGET, "line 5: kind 'blob'"),
        (lambda rows: [*rows, rows[1]], POINTS_TARGET, "stands in line 2 already"),
        (lambda rows: [*rows, rows[101]], POINTS_TARGET, "stands in line 102 already"),
        (lambda rows: rows[:1], POINTS_TARGET, "no points in it"),
        (lambda rows: [row[1:] for row in rows], POINTS_TARGET, "no column image"),
        (lambda rows: rows, "dots:9x10:10", "allowed on dots:9x10:10: rows 0 to 8"),
        (lambda rows: rows[:111], POINTS_TARGET, "1 usable pictures"),
        (
            lambda rows: [
                rows[0], *([f"copy {i}", *row[1:]] for i in range(5) for row in rows[1:111])
            ],
            POINTS_TARGET,
            "a copy of copy 0",
        ),
    ],
)  # fmt: skip
def test_points_that_could_mislead_are_refused(calibrated, edit, target, said):
    done, out = calibrated(edit, target)
    assert said in refused(done)
    assert not out.exists()


def stripes_of_another_sheet(rows):
    return [rows[0]] + [
        [*row[:5], str(float(row[5]) + 40.0), *row[6:]]
        if row[1] == "stripe" and row[0][-1] in "024"
        else row
        for row in rows[1:]
    ]


def test_stripes_that_contradict_each_other_fail_the_gates_and_are_told(calibrated):
    """A mistake that no row shows by itself."""
    done, out = calibrated(stripes_of_another_sheet)
    assert done.returncode == 1, (done.stdout, done.stderr)
    assert "fails the gates" in done.stderr
    assert json.loads(out.read_text())["warnings"]


def test_rows_and_columns_exchanged_are_the_same_board(calibrated):
    """Seen as if from behind: the points lie where they lay, and so does the plane."""
    planes = []
    for edit in (
        lambda rows: rows,
        lambda rows: [[*row[:2], row[3], row[2], *row[4:]] for row in rows],
    ):
        done, out = calibrated(edit)
        assert done.returncode == 0, done.stderr
        planes.append(json.loads(out.read_text())["plane"]["d"])
    assert planes[1] == pytest.approx(planes[0], abs=1e-3)


def test_a_camera_of_another_resolution_is_refused(station, points, folder, tmp_path):
    camera = json.loads((points[0] / "camera.json").read_text())
    other, out = tmp_path / "camera.json", tmp_path / "calibration.json"
    other.write_text(json.dumps({**camera, "width": 1024, "height": 544}))
    message = refused(
        station("calibrate", folder / "one", "--target", TARGET, "--camera", other, "--out", out)
    )
    assert "2048 x 1088 px but a camera of 1024 x 544" in message


def test_a_lens_that_folds_the_picture_over_is_refused(station, points, folder, tmp_path):
    camera = json.loads((points[0] / "camera.json").read_text())
    other, out = tmp_path / "camera.json", tmp_path / "calibration.json"
    other.write_text(json.dumps({**camera, "k1": -50.0}))
    message = refused(
        station("calibrate", folder / "one", "--target", TARGET, "--camera", other, "--out", out)
    )
    assert "folds the picture over" in message


@pytest.mark.parametrize("camera", [True, False])
def test_pictures_of_one_pixel_are_refused(station, points, tmp_path, camera):
    for name in ("a", "b", "c"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.full((1, 1), 90, np.uint8))
    given = ("--camera", points[0] / "camera.json") if camera else ()
    out = tmp_path / "calibration.json"
    message = refused(station("calibrate", tmp_path, "--target", TARGET, *given, "--out", out))
    assert ("pictures of 1 x 1 px" if camera else "0 usable pictures") in message


def test_a_recording_cut_short_is_refused_with_its_cure(station, folder, tmp_path):
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    assert station("import", folder / "one", "--out", whole).returncode == 0
    data = whole.read_bytes()
    cut.write_bytes(data[: len(data) // 2])
    out = tmp_path / "calibration.json"
    message = refused(station("calibrate", cut, "--target", TARGET, "--out", out))
    assert "station recording recover" in message


def test_measure_says_that_the_calibration_is_none(station, folder):
    message = refused(station("measure", folder / "one", "--calibration", folder / "text.png"))
    assert "CalibrationDocument" in message


def test_simulate_says_that_the_address_is_in_use(folder):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.99.99.98", 3956))
        message = refused(
            in_a_process(
                "camera", "simulate", "--address", "127.99.99.98", "--pictures", folder / "one"
            )
        )
    assert "127.99.99.98" in message
