"""Rendered pictures of a reference piece by two sensors at once, from files to verdict and rig."""

import json

import cv2
import numpy as np
import pytest
from wheel_recordings import true_calibration

from calib import Degenerate, RigidTransform
from measure import PieceVerdict
from station.cli.main import build_app, run
from station.documents import MountingDocument, PieceCheck, PieceDocument, RigDocument
from station.errors import InputUnusable
from station.pipeline import PieceOrder, calibrate_rig_on_piece, check_piece_on_rig
from station.scenes import PieceScene, paper_sensor, trackside_mounting

TRUTH = paper_sensor()
BELOW_RAD = np.radians(45.0)
# In one plane, axes 78 degrees apart.
POSES = {
    name: trackside_mounting("left", name, below_horizon_rad=BELOW_RAD)
    for name in ("inner", "outer")
}
CERTIFICATE = {
    "format": "treadline-piece",
    "version": 1,
    "name": "rib",
    "serial": "9",
    "profile": [[-40, 0], [-13, 0], [-13, 22], [-4, 22], [4, 16], [13, 16], [13, 3], [45, 3]],
    "u95_mm": 0.004,
    "squareness_deg": 0.5,
}
TEN = np.radians(10.0)
SLANTS = [(0.0, 0.0), (TEN, 0.0), (-TEN, 0.0), (0.0, TEN), (0.0, -TEN)]


def known():
    return PieceDocument.model_validate(CERTIFICATE).piece()


def held(slant_rad):
    """rig_from_piece where both sensors look, its length along the normal of the sheets."""
    piece = known()
    seen = [pose.apply(TRUTH.locate(np.array([[1000.0, 560.0]])))[0] for pose in POSES.values()]
    up = np.array([-np.cos(BELOW_RAD), 0.0, np.sin(BELOW_RAD)]) * -1.0
    x = np.array([0.0, 1.0, 0.0])
    upright = np.column_stack([x, np.cross(up, x), up])
    about_x, about_z = slant_rad
    lean = RigidTransform.from_rotation_vector([about_x, 0.0, about_z], np.zeros(3)).rotation
    middle_x, middle_z = piece.corners_mm.mean(axis=0)
    rotation = upright @ lean
    return RigidTransform(
        rotation, np.mean(seen, axis=0) - rotation @ np.array([middle_x, 0.0, middle_z])
    )


def calibration(name, *, pose=None):
    pose = pose or POSES[name]
    mounting = MountingDocument(
        rotation_vector=tuple(pose.rotation_vector.tolist()),
        translation_mm=tuple(pose.translation_mm.tolist()),
    )
    return true_calibration(name).model_copy(update={"mounting": mounting})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of pictures a sensor, of five placings; the certificate and the calibrations."""
    folder = tmp_path_factory.mktemp("piece")
    (folder / "piece.json").write_text(json.dumps(CERTIFICATE))
    for name, pose in POSES.items():
        (folder / name).mkdir()
        calibration(name).write(folder / f"{name}.json")
        for place, slant in enumerate(SLANTS):
            scene = PieceScene(TRUTH, pose.inverse() @ held(slant), known(), seed=place)
            picture = scene.render(np.random.default_rng([place, len(name)]))
            cv2.imwrite(str(folder / name / f"{place}.png"), picture)
    return folder


@pytest.fixture(scope="module")
def order():
    return PieceOrder(rig="left", calibrations=tuple(calibration(name) for name in POSES))


@pytest.fixture(scope="module")
def rig(folder, order):
    return calibrate_rig_on_piece([folder / name for name in POSES], order, known())


def first_of(folder):
    return [folder / name / "0.png" for name in POSES]


def station(capsys, *arguments):
    capsys.readouterr()
    code = run(build_app(arguments[0]), list(map(str, arguments)))
    out, err = capsys.readouterr()
    return code, out, err


def test_a_rig_is_found_from_pictures_of_a_piece(rig, folder):
    assert (rig.method, rig.anchor, rig.names) == ("piece", "inner", ("inner", "outer"))
    assert rig.quality["shots_used"].value == len(SLANTS)
    assert rig.passed, rig.quality
    assert rig.survey is not None
    found = rig.to_rig()
    off = found["outer"].locate(np.array([[1000.0, 560.0]])) - POSES["outer"].apply(
        TRUTH.locate(np.array([[1000.0, 560.0]]))
    )
    along = np.array([np.cos(BELOW_RAD + np.pi / 2), 0.0, -np.sin(BELOW_RAD + np.pi / 2)])
    # Light, blur and speckle of pictures leave some um in the section, in which wheels are read.
    assert np.linalg.norm(off - (off @ along)[:, None] * along) < 0.03
    assert len(rig.inputs) == 2 * len(SLANTS)


def test_a_rig_document_from_a_piece_is_kept(rig, tmp_path):
    rig.write(tmp_path / "rig.json")
    assert RigDocument.read(tmp_path / "rig.json") == rig


def test_the_rig_is_true_on_the_piece_and_the_check_can_be_kept(rig, folder, tmp_path):
    check = check_piece_on_rig(first_of(folder), rig, known())
    assert check.verdict is PieceVerdict.TRUE, check.reason
    assert (check.sensor, check.calibration) == ("left", rig.fingerprint)
    assert [picture.sensor for picture in check.pictures] == ["inner", "outer"]
    assert {one.unit for one in check.powers} == {"mm", "rad"}
    check.write(tmp_path / "check.json")
    assert PieceCheck.read(tmp_path / "check.json") == check


def test_command_finds_a_sensor_that_was_knocked(rig, folder, capsys, tmp_path):
    knocked = rig.sensors[1].model_copy(
        update={"translation_mm": tuple(np.add(rig.sensors[1].translation_mm, [0.0, 0.3, 0.0]))}
    )
    rig.model_copy(update={"sensors": (rig.sensors[0], knocked)}).write(tmp_path / "rig.json")
    arguments = ["--rig", tmp_path / "rig.json", "--piece", folder / "piece.json"]
    code, out, err = station(capsys, "evaluate", "piece", *first_of(folder), *arguments)
    assert code == 1
    assert "shift x outer" in out
    assert "found from" in out
    assert "drifted" in err
    assert err.count("\n") == 1


def test_command_wants_a_calibration_or_a_rig_and_a_picture_of_each_sensor(
    rig, folder, capsys, tmp_path
):
    rig.write(tmp_path / "rig.json")
    piece = ["--piece", folder / "piece.json"]
    both = ["--rig", tmp_path / "rig.json", "--calibration", folder / "inner.json"]
    for arguments, words in (
        ([*first_of(folder), *piece], "--calibration of one sensor, or --rig"),
        ([*first_of(folder), *piece, *both], "--calibration of one sensor, or --rig"),
        ([first_of(folder)[0], *piece, *both[:2]], "no SOURCE of sensor outer"),
    ):
        code, out, err = station(capsys, "evaluate", "piece", *arguments)
        assert (code, out) == (2, "")
        assert words in err


def test_rig_command_calibrates_on_a_piece(folder, capsys, tmp_path):
    sources = [folder / name for name in POSES]
    calibrations = [part for name in POSES for part in ("--calibration", folder / f"{name}.json")]
    out_file = tmp_path / "rig.json"
    code, out, err = station(
        capsys,
        *["rig", "calibrate", *sources, *calibrations],
        *["--piece", folder / "piece.json", "--rig", "left", "--out", out_file],
    )
    assert (code, err) == (0, "")
    assert "outer" in out
    assert RigDocument.read(out_file).method == "piece"


def test_one_placing_tells_no_rig_and_the_refusal_is_one_line(folder, order, capsys, tmp_path):
    with pytest.raises(Degenerate, match="show the piece in four placings"):
        calibrate_rig_on_piece(first_of(folder), order, known())
    calibrations = [part for name in POSES for part in ("--calibration", folder / f"{name}.json")]
    code, out, err = station(
        capsys,
        *["rig", "calibrate", *first_of(folder), *calibrations],
        *["--piece", folder / "piece.json", "--out", tmp_path / "rig.json"],
    )
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


def test_orders_that_make_no_rig_are_refused():
    inner = calibration("inner")
    nowhere = true_calibration("outer").model_copy(update={"mounting": None})
    with pytest.raises(InputUnusable, match="two or more sensors"):
        PieceOrder(rig="left", calibrations=(inner,))
    with pytest.raises(InputUnusable, match="nothing says where outer stands"):
        PieceOrder(rig="left", calibrations=(inner, nowhere))
    with pytest.raises(InputUnusable, match="sigma_start_mm is 0"):
        PieceOrder(rig="left", calibrations=(inner, calibration("outer")), sigma_start_mm=0.0)
