"""Pictures, recordings and points of other detectors become calibrations; misfits are refused."""

import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest

from calib import Method, Target, sheet_difference_mm
from station.demo import working_field_px
from station.documents import CalibrationDocument
from station.errors import InputUnusable
from station.pipeline import calibrate_camera_from_sources, calibrate_sources
from station.settings import MountingSettings

TARGET = Target.parse("dots:7x8:12:d=6")


@pytest.fixture(scope="module")
def outcome(poses, truth):
    return calibrate_sources([poses / "on"], TARGET, camera=truth.camera, sensor="left")


def rms_mm(document, truth):
    difference = sheet_difference_mm(document.laser_sensor(), truth, working_field_px(truth))
    return float(np.sqrt(np.nanmean(difference**2)))


def test_good_pictures_give_a_calibration_that_passes_its_gates(outcome, truth):
    document = outcome.document
    assert document.passed, document.quality
    assert (document.sensor, len(document.poses), outcome.left_out) == ("left", 6, ())
    # Six poses in good light; twenty are held to 0.005 mm.
    assert rms_mm(document, truth) < 0.02


def test_document_names_what_went_in(outcome, poses):
    assert [one.name for one in outcome.document.inputs] == [f"pose{i}.png" for i in range(6)]
    assert all(len(one.sha256) == 64 for one in outcome.document.inputs)
    assert outcome.document.options["target"] == str(TARGET)


def test_document_comes_back_from_its_file_as_it_was(outcome, tmp_path):
    outcome.document.write(tmp_path / "calibration.json")
    back = CalibrationDocument.read(tmp_path / "calibration.json")
    assert back == outcome.document
    assert back.fingerprint == outcome.document.fingerprint


def test_its_own_points_solved_again_give_the_same_plane(outcome, truth, tmp_path):
    path = tmp_path / "points.csv"
    path.write_text(outcome.points_csv)
    again = calibrate_sources([path], TARGET, camera=truth.camera).document
    # Six decimals of a pixel are kept; what the pictures said of single points' causes is not.
    difference = sheet_difference_mm(
        again.laser_sensor(), outcome.document.laser_sensor(), working_field_px(truth)
    )
    assert np.nanmax(difference) < 0.3 * outcome.document.quality["sheet_sigma_mm"].value


@pytest.mark.parametrize("method", list(Method))
def test_every_method_gives_a_plane_and_says_which_it_was(poses, truth, method):
    document = calibrate_sources(
        [poses / "on"], TARGET, camera=truth.camera, method=method
    ).document
    assert document.method == method
    assert rms_mm(document, truth) < 0.1


def test_pictures_without_laser_are_used_where_given(poses, truth):
    document = calibrate_sources(
        [poses / "on"], TARGET, camera=truth.camera, laser_off=[poses / "off"]
    ).document
    assert rms_mm(document, truth) < 0.02
    assert len(document.inputs) == 12


def test_mounting_is_kept_with_the_calibration(poses, truth):
    mounting = MountingSettings(rotation_vector=(0.1, 0.2, 0.3), translation_mm=(1, 2, 3))
    document = calibrate_sources(
        [poses / "on"], TARGET, camera=truth.camera, mounting=mounting
    ).document
    assert document.mounting.settings() == mounting


def test_picture_without_target_is_left_out_and_named(poses, truth, tmp_path):
    folder = tmp_path / "mixed"
    shutil.copytree(poses / "on", folder)
    cv2.imwrite(str(folder / "dark.png"), np.zeros((1088, 2048), np.uint8))
    outcome = calibrate_sources([folder], TARGET, camera=truth.camera)
    assert [name for name, _ in outcome.left_out] == ["dark.png"]
    assert outcome.document.left_out.keys() == {"dark.png"}
    assert len(outcome.document.poses) == 6


def test_camera_is_solved_from_the_same_pictures_where_none_is_given(poses, truth):
    camera = calibrate_camera_from_sources([poses / "on"], TARGET)
    sigma = np.sqrt(np.diag(camera.covariance)[:2])
    error = camera.parameters[:2] - truth.camera.parameters[:2]
    assert (np.abs(error) < 5.0 * sigma).all()


@pytest.mark.parametrize(
    ("camera_width", "laser_off", "said"),
    [(1024, False, "but a camera of 1024"), (2048, True, "more laser-off pictures than")],
)
def test_what_does_not_fit_together_is_refused(poses, truth, camera_width, laser_off, said):
    with pytest.raises(InputUnusable, match=said):
        calibrate_sources(
            [poses / "on" / "pose0.png"],
            TARGET,
            camera=replace(truth.camera, width=camera_width),
            laser_off=[poses / "off"] if laser_off else (),
        )


def test_pictures_of_two_sizes_are_refused_by_name(poses, truth, tmp_path):
    folder = tmp_path / "mixed"
    shutil.copytree(poses / "on", folder)
    cv2.imwrite(str(folder / "small.png"), np.zeros((10, 10), np.uint8))
    with pytest.raises(InputUnusable, match=r"small\.png is 10 x 10 px"):
        calibrate_sources([folder], TARGET, camera=truth.camera)


def test_points_alone_do_not_tell_the_size_of_the_pictures(outcome, tmp_path):
    path = tmp_path / "points.csv"
    path.write_text(outcome.points_csv)
    with pytest.raises(InputUnusable, match="--camera"):
        calibrate_sources([path], TARGET)
