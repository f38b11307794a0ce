"""`evaluate`, `compare` and `table` on rendered pictures, from arguments to exit code."""

import json

import cv2
import numpy as np
import pytest

from calib import Target
from station.cli.main import build_app, run
from station.documents import CalibrationDocument, CameraDocument
from station.scenes import (
    CylinderScene,
    Light,
    cylinder_poses,
    paper_sensor,
    target_scenes,
)

TARGET = "dots:7x8:12:d=6"
TRUTH = paper_sensor()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Five pictures of a target, two of a cylinder, and a calibration of the five."""
    folder = tmp_path_factory.mktemp("evaluate")
    rng = np.random.default_rng(11)
    (folder / "target").mkdir()
    (folder / "cylinder").mkdir()
    for index, scene in enumerate(
        target_scenes(rng, TRUTH, Target.parse(TARGET), [Light.GOOD] * 5)
    ):
        cv2.imwrite(str(folder / "target" / f"{index}.png"), scene.render(rng))
    for index, pose in enumerate(cylinder_poses(rng, 2, TRUTH)):
        picture = CylinderScene(TRUTH, pose, seed=index).render(rng)
        cv2.imwrite(str(folder / "cylinder" / f"{index}.png"), picture)
        np.savetxt(folder / f"axis{index}.txt", pose.rotation[:, 2])
    CameraDocument.from_model(TRUTH.camera).write(folder / "camera.json")
    answer = run(
        build_app("calibrate"),
        [
            "calibrate",
            *map(str, (folder / "target", "--target", TARGET)),
            "--camera",
            str(folder / "camera.json"),
            "--out",
            str(folder / "a.json"),
        ],
    )
    assert answer == 0
    return folder


def station(capsys, *arguments):
    capsys.readouterr()
    words = [str(argument) for argument in arguments]
    code = run(build_app(words[0]), words)
    out, err = capsys.readouterr()
    return code, out, err


def test_distances_are_within_the_limit_they_are_held_against(folder, capsys):
    arguments = [
        "evaluate",
        "distances",
        folder / "target",
        "--target",
        TARGET,
        "--calibration",
        folder / "a.json",
        "--json",
    ]
    code, out, _ = station(capsys, *arguments, "--limit", 0.02)
    data = json.loads(out)
    assert code == 0
    assert data["rms_mm"] < 0.02
    assert data["distances"] == sum(len(p["measured_mm"]) for p in data["placements"])
    code, out, err = station(capsys, *arguments, "--limit", data["rms_mm"] / 2.0)
    assert code == 1
    assert json.loads(out)["rms_mm"] == data["rms_mm"]
    assert err.count("\n") == 1
    assert "limit" in err


def test_distances_of_pictures_without_a_target_are_no_answer(folder, capsys):
    code, out, err = station(
        capsys,
        "evaluate",
        "distances",
        folder / "cylinder",
        "--target",
        TARGET,
        "--calibration",
        folder / "a.json",
    )
    assert (code, out) == (1, "")
    assert "0.png" in err


def test_cylinder_on_a_known_axis_is_read_to_three_hundredths(folder, capsys):
    axis = ",".join(map(str, np.loadtxt(folder / "axis0.txt")))
    code, out, _ = station(
        capsys,
        "evaluate",
        "cylinder",
        folder / "cylinder" / "0.png",
        "--calibration",
        folder / "a.json",
        "--radius",
        30,
        "--axis",
        axis,
        "--limit",
        0.03,
        "--json",
    )
    assert code == 0
    (reading,) = json.loads(out)["readings"]
    assert reading["radius_mm"] == pytest.approx(30.0, abs=0.03)
    assert reading["rms_mm"] < 0.03


def test_cylinder_on_a_free_axis_is_told_with_its_uncertainty(folder, capsys):
    code, out, _ = station(
        capsys,
        "evaluate",
        "cylinder",
        folder / "cylinder",
        "--calibration",
        folder / "a.json",
        "--radius",
        30,
        "--json",
    )
    assert code == 0
    data = json.loads(out)
    # 1.5 half-widths of a 95 % interval are three sigmas.
    for reading in [data, *data["readings"]]:
        assert abs(reading["radius_mm"] - 30.0) < 1.5 * reading["u95_mm"]
    for reading in data["readings"]:
        assert abs(reading["alone_mm"] - 30.0) < 1.5 * reading["alone_u95_mm"]
    # What all share is known better than by the worst alone.
    assert data["u95_mm"] < max(reading["alone_u95_mm"] for reading in data["readings"])


def test_axis_that_was_turned_is_not_taken_for_a_common_one(folder, capsys):
    code, out, err = station(
        capsys,
        "evaluate",
        "cylinder",
        folder / "cylinder",
        "--calibration",
        folder / "a.json",
        "--radius",
        30,
        "--axis",
        "common",
    )
    assert (code, out) == (1, "")
    assert "chi-square" in err


def test_pictures_without_a_cylinder_are_no_answer(folder, capsys):
    code, out, err = station(
        capsys,
        "evaluate",
        "cylinder",
        folder / "target",
        "--calibration",
        folder / "a.json",
        "--radius",
        200,
    )
    assert (code, out) == (1, "")
    assert "no cylinder" in err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--radius", "0"], "more than 0"),
        (["--radius", "30", "--axis", "upright"], "free, common, square, or X,Y,Z"),
        (["--radius", "30", "--axis", "1,0,0"], "60 degrees"),
        (["--radius", "30", "--axis", "0,nan,0"], "free, common, square, or X,Y,Z"),
    ],
)
def test_cylinder_says_what_it_allows(folder, capsys, options, said):
    code, out, err = station(
        capsys,
        "evaluate",
        "cylinder",
        folder / "cylinder",
        "--calibration",
        folder / "a.json",
        *options,
    )
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_picture_of_another_camera_is_refused(folder, tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((60, 80), dtype=np.uint8))
    code, _, err = station(
        capsys,
        "evaluate",
        "cylinder",
        tmp_path,
        "--calibration",
        folder / "a.json",
        "--radius",
        30,
    )
    assert code == 2
    assert "80 x 60 px but the calibration is of 2048 x 1088" in err


def test_repeatability_tells_every_method_and_is_the_same_for_a_seed(folder, capsys):
    arguments = [
        "evaluate",
        "repeatability",
        folder / "target",
        "--target",
        TARGET,
        "--camera",
        folder / "camera.json",
        "--draws",
        2,
        "--take",
        3,
        "--json",
    ]
    code, out, _ = station(capsys, *arguments)
    assert code == 0
    methods = json.loads(out)["methods"]
    assert set(methods) >= {"preplanar", "joint"}
    assert set(methods["joint"]["spread"]) == set("abcd")
    assert json.loads(station(capsys, *arguments)[1])["methods"] == methods


def test_repeatability_of_too_few_pictures_is_refused(folder, capsys):
    code, _, err = station(
        capsys,
        "evaluate",
        "repeatability",
        folder / "target",
        "--target",
        TARGET,
        "--camera",
        folder / "camera.json",
        "--take",
        10,
    )
    assert code == 2
    assert "5 pictures" in err


def test_leave_one_out_names_every_pose(folder, capsys):
    code, out, _ = station(
        capsys,
        "evaluate",
        "leave-one-out",
        folder / "target",
        "--target",
        TARGET,
        "--camera",
        folder / "camera.json",
        "--json",
    )
    data = json.loads(out)
    assert code == 0
    assert [pose["name"] for pose in data["poses"]] == [f"{i}.png" for i in range(5)]
    assert data["rms_mm"] < 0.1


def shifted(folder, by_mm, name="b.json", **changes):
    document = CalibrationDocument.read(folder / "a.json")
    plane = document.plane.model_copy(update={"d": document.plane.d + by_mm})
    document.model_copy(update={"plane": plane, **changes}).write(folder / name)
    return folder / name


def test_calibration_agrees_with_itself(folder, capsys):
    code, out, _ = station(capsys, "compare", folder / "a.json", folder / "a.json", "--json")
    data = json.loads(out)
    assert code == 0
    assert data["agree"]
    assert data["rms_mm"] == 0.0


def test_calibration_moved_by_more_than_its_uncertainty_differs(folder, capsys):
    other = shifted(folder, 0.5)
    code, out, err = station(capsys, "compare", folder / "a.json", other, "--json", "--limit", 0.1)
    data = json.loads(out)
    assert code == 1
    assert "RMS difference" in err
    assert not data["agree"]
    # A parallel sheet is met 0.5 mm over the sine of sheet and ray farther: 0.57 in the middle.
    assert 0.5 < data["rms_mm"] < 1.5
    grid = np.array(data["map"]["difference_mm"], dtype=float)
    assert grid.shape == (len(data["map"]["v_px"]), len(data["map"]["u_px"]))
    assert np.nanmax(grid) == pytest.approx(data["largest_mm"], abs=1e-6)


def test_field_is_where_the_targets_were(folder, capsys):
    _, out, _ = station(capsys, "compare", folder / "a.json", folder / "a.json", "--json")
    assert len(json.loads(out)["map"]["v_px"]) < 1088 / 32
    anywhere = shifted(folder, 0.0, "c.json", options={})
    _, out, _ = station(capsys, "compare", anywhere, anywhere, "--json")
    assert len(json.loads(out)["map"]["v_px"]) == 1088 / 32


def test_calibrations_of_different_cameras_are_not_compared(folder, capsys):
    document = CalibrationDocument.read(folder / "a.json")
    camera = document.camera.model_copy(update={"width": 1024})
    other = shifted(folder, 0.0, "small.json", camera=camera)
    code, out, err = station(capsys, "compare", folder / "a.json", other)
    assert (code, out) == (2, "")
    assert "1024 x 1088" in err


def test_table_can_be_used_with_nothing_but_numpy(folder, tmp_path, capsys):
    out_file = tmp_path / "sheet.npz"
    code, out, _ = station(
        capsys, "table", folder / "a.json", "--out", out_file, "--step", 64, "--json"
    )
    assert code == 0
    with np.load(out_file, allow_pickle=False) as table:
        arrays = dict(table)
    metadata = json.loads(str(arrays.pop("metadata")))
    assert set(metadata["arrays"]) == {*arrays, "metadata"}
    rebuilt = arrays["origin_in_cam_mm"] + arrays["sheet_mm"] @ arrays["axes_in_cam"]
    np.testing.assert_allclose(rebuilt, arrays["in_cam_mm"], atol=1e-9)
    off = arrays["in_cam_mm"] @ arrays["plane"][:3] + arrays["plane"][3]
    np.testing.assert_allclose(off, 0.0, atol=1e-9)
    assert json.loads(out)["located"] == np.isfinite(arrays["sigma_mm"]).sum()
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.npz"]


def test_table_of_another_suffix_is_refused(folder, tmp_path, capsys):
    code, _, err = station(capsys, "table", folder / "a.json", "--out", tmp_path / "sheet.csv")
    assert code == 2
    assert ".npz" in err
