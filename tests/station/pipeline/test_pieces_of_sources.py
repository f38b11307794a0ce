"""Pictures of a reference piece, from files to the verdict and the exit code."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from wheel_recordings import true_calibration

from measure import Piece, PieceVerdict
from station.cli.main import build_app, run
from station.documents import PieceCheck, PieceDocument
from station.errors import InputUnusable
from station.pipeline import check_piece
from station.scenes import PieceScene, paper_sensor, piece_pose

TRUTH = paper_sensor()
CERTIFICATE = {
    "format": "treadline-piece",
    "version": 1,
    "name": "ridges",
    "serial": "42",
    "profile": [[0, 0], [25, 0], [35, 10], [65, 10], [75, 0], [100, 0]],
    "u95_mm": 0.004,
    "held_u95_mm": 0.01,
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two pictures of a piece, one with the laser off, its certificate, and a calibration."""
    folder = tmp_path_factory.mktemp("piece")
    (folder / "piece.json").write_text(json.dumps(CERTIFICATE))
    true_calibration().write(folder / "true.json")
    known = PieceDocument.model_validate(CERTIFICATE).piece()
    (folder / "on").mkdir()
    for place, middle in enumerate([(950.0, 520.0), (1050.0, 600.0)]):
        pose = piece_pose(TRUTH, known, middle_px=middle, turn_rad=0.1)
        scene = PieceScene(TRUTH, pose, known, seed=place)
        cv2.imwrite(str(folder / "on" / f"{place}.png"), scene.render(np.random.default_rng(place)))
        dark = replace(scene, laser_on=False).render(np.random.default_rng(9))
        cv2.imwrite(str(folder / f"off{place}.png"), dark)
    return folder


@pytest.fixture(scope="module")
def known():
    return PieceDocument.model_validate(CERTIFICATE).piece()


def station(capsys, *arguments):
    capsys.readouterr()
    code = run(build_app("evaluate"), ["evaluate", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_a_true_sensor_passes_and_the_check_can_be_kept(folder, known, tmp_path):
    check = check_piece([folder / "on"], true_calibration(), known)
    assert check.verdict is PieceVerdict.TRUE, check.reason
    assert check.passed
    assert (check.piece, check.serial) == ("ridges", "42")
    assert [picture.name for picture in check.pictures] == ["0.png", "1.png"]
    check.write(tmp_path / "check.json")
    assert PieceCheck.read(tmp_path / "check.json") == check


def test_laser_off_pictures_take_the_surroundings_away(folder, known):
    one = folder / "on" / "0.png"
    check = check_piece([one], true_calibration(), known, laser_off=[folder / "off0.png"])
    assert check.verdict is PieceVerdict.TRUE, check.reason
    both = [folder / "off0.png", folder / "off1.png"]
    with pytest.raises(InputUnusable, match="2 laser-off pictures for 1"):
        check_piece([one], true_calibration(), known, laser_off=both)


def test_a_held_piece_is_compared_with_an_earlier_check(folder, known):
    first = check_piece([folder / "on" / "0.png"], true_calibration(), known)
    again = check_piece([folder / "on" / "0.png"], true_calibration(), known, since=first)
    assert again.passed
    assert "place" in [one.name for one in again.deviations]
    elsewhere = check_piece([folder / "on" / "1.png"], true_calibration(), known, since=first)
    assert elsewhere.verdict is PieceVerdict.DRIFTED
    assert "place" in elsewhere.reason


def test_a_check_by_another_calibration_or_of_another_piece_is_not_compared(folder, known):
    one = [folder / "on" / "0.png"]
    first = check_piece(one, true_calibration(), known)
    other = true_calibration().model_copy(update={"method": "deviation"})
    with pytest.raises(InputUnusable, match="another calibration"):
        check_piece(one, other, known, since=first)
    with pytest.raises(InputUnusable, match="same piece"):
        check_piece(one, true_calibration(), replace(known, serial="43"), since=first)


def test_pictures_of_another_camera_or_sensor_are_refused(folder, known, tmp_path):
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((100, 100), np.uint8))
    with pytest.raises(InputUnusable, match="100 x 100"):
        check_piece([tmp_path / "small.png"], true_calibration(), known)
    with pytest.raises(InputUnusable, match="no SOURCE"):
        check_piece([], true_calibration(), known)


def test_command_prints_a_table_and_passes(folder, capsys, tmp_path):
    arguments = ["--calibration", folder / "true.json", "--piece", folder / "piece.json"]
    code, out, err = station(
        capsys, "piece", folder / "on", *arguments, "--out", tmp_path / "check.json"
    )
    assert (code, err) == (0, "")
    assert "height 1-3" in out
    assert "tells the truth" in out.splitlines()[-1]
    assert PieceCheck.read(tmp_path / "check.json").passed


def test_command_fails_a_drifted_sensor_and_still_prints_what_was_found(folder, capsys):
    parameters = TRUTH.camera.parameters.copy()
    parameters[:2] *= 0.99
    drifted = true_calibration()
    camera = drifted.camera.model_copy(update={"fx": parameters[0], "fy": parameters[1]})
    drifted.model_copy(update={"camera": camera}).write(folder / "drifted.json")
    arguments = ["--calibration", folder / "drifted.json", "--piece", folder / "piece.json"]
    code, out, err = station(capsys, "piece", folder / "on", *arguments, "--json")
    assert code == 1
    assert json.loads(out)["verdict"] == "drifted"
    assert err.count("\n") == 1
    assert "drifted" in err


def test_command_says_that_it_cannot_say(folder, capsys):
    arguments = ["--calibration", folder / "true.json", "--piece", folder / "piece.json"]
    code, out, err = station(capsys, "piece", folder / "off0.png", *arguments, "--json")
    assert code == 1
    assert json.loads(out)["verdict"] == "cannot say"
    assert "cannot say" in err


def test_step_command_reads_the_height_of_a_step(capsys, tmp_path, folder):
    step = Piece.step(10.0, width_mm=25.0)
    pose = piece_pose(TRUTH, step, middle_px=(1000.0, 560.0))
    scene = PieceScene(TRUTH, pose, step)
    cv2.imwrite(str(tmp_path / "step.png"), scene.render(np.random.default_rng(2)))
    arguments = ["step", tmp_path / "step.png", "--calibration", folder / "true.json"]
    code, out, _ = station(capsys, *arguments, "--height", 10, "--json")
    assert code == 0
    (height,) = [one for one in json.loads(out)["deviations"] if one["name"].startswith("height")]
    # 1.5 half-widths of a 95 % interval are three sigmas.
    assert abs(height["found"] - 10.0) < 1.5 * height["u95"] < 0.06
    code, _, err = station(capsys, *arguments, "--height", 10.3)
    assert code == 1
    assert "drifted" in err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"profile": [[0, 0]]}, "two or more"),
        ({"format": "treadline-calibration"}, "format"),
        ({"u95_mm": -1}, "u95_mm"),
    ],
)
def test_a_certificate_that_is_none_is_one_line(folder, capsys, tmp_path, change, words):
    (tmp_path / "bad.json").write_text(json.dumps({**CERTIFICATE, **change}))
    arguments = ["--calibration", folder / "true.json", "--piece", tmp_path / "bad.json"]
    code, out, err = station(capsys, "piece", folder / "on", *arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert words in err
    code, out, err = station(
        capsys, "step", folder / "on", "--calibration", folder / "true.json", "--height", -1
    )
    assert (code, out) == (2, "")
    assert "height" in err
