"""`station rig`: from points seen by two sensors to rig.json, looked at and compared."""

import json

import numpy as np
import pytest
from rig_recordings import INNER, OUTER, TRUTH, calibration_of, true_rig
from shown_points import write_showings

from station.cli.main import build_app, run
from station.documents import RigDocument

BOARD = "dots:7x8:12"
SETTINGS = """
data_dir = "data"
[[sensors]]
id = "inner"
address = "192.168.1.2"
[[sensors]]
id = "outer"
address = "192.168.1.3"
[[rigs]]
id = "wheel"
sensors = ["inner", "outer"]
anchor = "outer"
sigma_vibration_mm = 0.1
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Eight showings; the outer sensor has no picture of the third."""
    folder = tmp_path_factory.mktemp("rig")
    write_showings(folder, np.random.default_rng(4), 8, missing=[(OUTER, 2)])
    for name in (INNER, OUTER):
        calibration_of(name).write(folder / f"{name}.json")
    true_rig().write(folder / "true.json")
    (folder / "station.toml").write_text(SETTINGS)
    return folder


def command(folder, *more, sources=(INNER, OUTER)):
    points = [str(folder / f"{name}.csv") for name in sources]
    calibrations = [f"--calibration={folder / f'{name}.json'}" for name in (INNER, OUTER)]
    return ["rig", "calibrate", *points, *calibrations, *map(str, more)]


def calibrate(folder, out, *more):
    given = command(folder, f"--target={BOARD}", "--board-sigma-mm=0", f"--out={out}", *more)
    return run(build_app("rig"), given)


@pytest.fixture(scope="module")
def rig(folder):
    path = folder / "rig.json"
    assert calibrate(folder, path, "--rig=wheel") == 0
    return path


def test_a_rig_is_solved_where_its_anchor_is_surveyed_and_names_what_it_rests_on(rig):
    document = RigDocument.read(rig)
    assert (document.rig, document.side, document.method) == ("wheel", "left", "boards")
    assert (document.anchor, document.names) == (INNER, (INNER, OUTER))
    assert document.calibrations == {
        name: calibration_of(name).fingerprint for name in (INNER, OUTER)
    }
    assert document.left_out["pose2 outer"] == "no picture of outer"
    assert [each.name for each in document.inputs] == ["inner.csv", "outer.csv"]
    found = document.to_rig()[OUTER].rig_from_camera
    known = TRUTH.exact[OUTER].rig_from_camera
    # Seven pairs of 56 dots of 0.05 px; 0.25 mm a pixel: some micrometres, told by the covariance.
    columns = document.to_rig().columns(OUTER)[-3:]
    sigma = np.sqrt(np.diag(document.to_rig().covariance)[columns])
    off = np.abs(found.translation_mm - known.translation_mm)
    assert (sigma < 0.1).all()
    assert (off < 4.5 * sigma).all()


def test_a_rig_can_be_looked_at(rig, capsys):
    assert run(build_app("rig"), ["rig", "show", str(rig)]) == 0
    text = capsys.readouterr().out
    assert "inner: the anchor" in text
    assert "left out pose2 outer: no picture of outer" in text
    assert "placing_sigma_mm" in text
    assert run(build_app("rig"), ["rig", "show", str(rig), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["format"] == "treadline-rig"


def test_a_rig_agrees_with_the_truth_within_its_uncertainty(folder, rig, capsys):
    compare = ["rig", "compare", str(rig), str(folder / "true.json")]
    assert run(build_app("rig"), [*compare, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["anchor"] == INNER
    assert list(found["sensors"]) == [OUTER]
    assert found["sensors"][OUTER]["agree"]
    assert run(build_app("rig"), [*compare, "--limit=0.000001"]) == 1
    assert "RMS difference of outer is" in capsys.readouterr().err


def test_settings_name_the_anchor_and_how_much_the_sensors_vibrate(folder, tmp_path):
    out = tmp_path / "rig.json"
    assert calibrate(folder, out, "--rig=wheel", f"--config={folder / 'station.toml'}") == 0
    document = RigDocument.read(out)
    assert document.anchor == OUTER
    assert document.survey.sigma_vibration_mm == 0.1


def test_without_a_mounting_the_frame_is_the_anchors_camera_and_show_says_what_that_means(
    folder, tmp_path, capsys
):
    calibrations = []
    for name in (INNER, OUTER):
        path = tmp_path / f"{name}.json"
        calibration_of(name, with_mounting=False).write(path)
        calibrations.append(f"--calibration={path}")
    out = tmp_path / "rig.json"
    points = [str(folder / f"{name}.csv") for name in (INNER, OUTER)]
    options = [f"--target={BOARD}", "--board-sigma-mm=0", f"--out={out}"]
    assert run(build_app("rig"), ["rig", "calibrate", *points, *calibrations, *options]) == 0
    assert "it cannot measure wheels" in capsys.readouterr().out
    np.testing.assert_allclose(
        RigDocument.read(out).to_rig()[INNER].rig_from_camera.rotation, np.eye(3)
    )


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ([], "give either --target of the boards, or --piece"),
        ([f"--target={BOARD}"] * 3, "3 targets for 2 sensors; allowed: one for all, or one for"),
        ([f"--target={BOARD}", "--anchor=middle"], "anchor middle; allowed: inner, outer"),
        ([f"--target={BOARD}", "--temperature=20"], "go with --piece"),
        ([f"--target={BOARD}", "--rig=other", "--config={folder}/station.toml"], "has wheel; give"),
        (["--target=dots:7x8"], "dots:7x8"),
    ],
)
def test_what_makes_no_rig_is_refused_in_one_line(folder, tmp_path, capsys, more, says):
    more = [each.format(folder=folder) for each in more]
    assert run(build_app("rig"), command(folder, *more, f"--out={tmp_path / 'rig.json'}")) == 2
    told = capsys.readouterr().err
    assert says in told
    assert told.count("\n") == 1
    assert not (tmp_path / "rig.json").exists()


def test_rigs_of_other_sensors_cannot_be_compared(rig, folder, tmp_path, capsys):
    strange = json.loads((folder / "true.json").read_text())
    strange["anchor"] = strange["sensors"][0]["sensor"] = "first"
    path = tmp_path / "strange.json"
    path.write_text(json.dumps(strange))
    assert run(build_app("rig"), ["rig", "compare", str(rig), str(path)]) == 2
    assert "the anchor inner is no sensor of the other rig" in capsys.readouterr().err
