"""`station record`, `recording` and `import`, as they are typed."""

import json

import cv2
import numpy as np
import pytest
from capture_rig import assert_served, served_pictures, small_camera

from station.cli.main import build_app, run
from station.recording import frames
from station.simulated import Faults


@pytest.fixture
def station(capsys):
    def command(*arguments):
        code = run(build_app(str(arguments[0])), [str(one) for one in arguments])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return command


def test_record_writes_the_frames_and_says_how_many(station, tmp_path):
    path = tmp_path / "a.mcap"
    with small_camera("127.20.4.1"):
        code, out, _ = station("record", "--camera", "127.20.4.1", "--out", path, "--frames", 10)
    assert code == 0
    assert "10 frames recorded, 0 lost" in out
    assert_served(path, 0, range(1, 11))


def test_record_says_how_many_frames_are_missing_and_exits_1(station, tmp_path):
    path = tmp_path / "a.mcap"
    faults = Faults(lost_frames=frozenset({3, 4, 7}))
    with small_camera("127.20.4.2", faults=faults):
        arguments = ("--camera", "127.20.4.2", "--out", path, "--frames", 12, "--json")
        code, out, err = station("record", *arguments)
    assert code == 1
    document = json.loads(out)
    assert (document["recorded"], document["lost"], document["complete"]) == (9, 3, False)
    assert "3 frames are missing" in err
    assert len(err.strip().splitlines()) == 1


def test_software_triggers_are_given_by_the_command(station, tmp_path):
    path = tmp_path / "a.mcap"
    with small_camera("127.20.4.3"):
        arguments = ("--camera", "127.20.4.3", "--out", path, "--frames", 3)
        code, out, err = station("record", *arguments, "--trigger", "software")
    assert code == 0, err
    assert "3 frames of 3 triggered recorded" in out


def test_camera_that_does_not_answer_is_one_line_and_exit_2(station, tmp_path):
    path = tmp_path / "a.mcap"
    code, out, err = station("record", "--camera", "127.20.4.9", "--out", path, "--frames", 1)
    assert (code, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert "no camera answers at 127.20.4.9" in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "seen"),
    [
        ((), "give --frames N or --seconds S"),
        (("--frames", 1, "--seconds", 1), "give --frames N or --seconds S"),
        (("--seconds", 0), "give more than 0"),
        (("--frames", 1, "--sensor", "Left Side"), "lower-case"),
        (("--frames", 1, "--exposure", -5), "more than 0"),
    ],
)
def test_record_that_cannot_be_meant_is_one_line_and_exit_2(station, tmp_path, arguments, seen):
    path = tmp_path / "a.mcap"
    code, _, err = station("record", "--camera", "127.20.4.9", "--out", path, *arguments)
    assert code == 2
    assert seen in err
    assert len(err.strip().splitlines()) == 1


def test_recording_that_exists_is_kept(station, tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"precious")
    arguments = ("--camera", "127.20.4.9", "--out", tmp_path / "a.mcap", "--frames", 1)
    code, _, err = station("record", *arguments)
    assert code == 2
    assert "exists" in err
    assert (tmp_path / "a.mcap").read_bytes() == b"precious"


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "pictures"
    folder.mkdir()
    for number, pixels in enumerate(served_pictures(count=12), 1):
        cv2.imwrite(str(folder / f"im{number}.png"), pixels)
    return folder


def test_imported_pictures_are_frames_in_natural_order(station, tmp_path, folder):
    path = tmp_path / "a.mcap"
    code, out, _ = station("import", folder, "--out", path, "--sensor", "left")
    assert code == 0
    assert "12 pictures" in out
    found = list(frames(path))
    assert [frame.frame_id for frame in found] == list(range(1, 13))
    for frame, pixels in zip(found, served_pictures(count=12), strict=True):
        np.testing.assert_array_equal(frame.picture, pixels)
        assert frame.sensor == "left"


def test_picture_that_is_none_leaves_no_recording(station, tmp_path, folder):
    (folder / "im5.png").write_bytes(b"no picture")
    code, _, err = station("import", folder, "--out", tmp_path / "a.mcap")
    assert code == 2
    assert "im5.png" in err
    assert sorted(one.name for one in tmp_path.iterdir()) == ["pictures"]


def test_recording_commands_tell_prove_and_repair(station, tmp_path, folder):
    path = tmp_path / "a.mcap"
    station("import", folder, "--out", path)
    code, out, _ = station("recording", "info", path, "--json")
    assert (code, json.loads(out)["sensors"][0]["frames"]) == (0, 12)
    code, out, _ = station("recording", "verify", path)
    assert (code, out.strip().endswith("sound")) == (0, True)
    path.write_bytes(path.read_bytes()[:-20_000])
    code, _, err = station("recording", "info", path)
    assert code == 2
    assert f"`station recording recover {path}`" in err
    code, out, _ = station("recording", "recover", path)
    assert code == 0
    assert "11 frames" in out


def test_damaged_recording_is_named_and_exits_1(station, tmp_path, folder):
    path = tmp_path / "a.mcap"
    station("import", folder, "--out", path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    code, _, err = station("recording", "verify", path)
    assert code == 1
    assert "is damaged" in err
