"""Frames of wheels become rows of results, measured or with a reason; misfits are refused."""

import cv2
import numpy as np
import pytest
from wheel_recordings import record

from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.pipeline import measure_sources


@pytest.fixture(scope="module")
def folder(tmp_path_factory, views):
    folder = tmp_path_factory.mktemp("wheels")
    for index, picture in enumerate([*views[:2], np.zeros_like(views[0])]):
        cv2.imwrite(str(folder / f"wheel{index}.png"), picture)
    return folder


def test_every_picture_is_a_wheel_and_a_dark_one_a_row_with_a_reason(folder, calibration, wheel):
    document = measure_sources([folder], calibration)
    assert [each.source for each in document.wheels] == [f"wheel{i}.png" for i in range(3)]
    assert [each.reason is None for each in document.wheels] == [True, True, False]
    assert [each.frame for each in document.wheels] == [0, 1, 2]
    assert document.wheels[2].tread_wear.value is None
    assert document.wheels[2].tread_wear.status == "missing"
    for measured in document.wheels[:2]:
        # What is asked of a reading in good light with the true sensor, three times over for one.
        assert measured.tread_wear.value == pytest.approx(wheel.readings.tread_wear, abs=0.06)


def test_close_frames_of_a_recording_are_one_wheel(tmp_path, views, calibration):
    (path,) = record(tmp_path / "train.mcap", [views[:2], views[:2]])
    document = measure_sources([path], calibration)
    assert [wheel.frames for wheel in document.wheels] == [(1, 2), (3, 4)]
    assert {wheel.sensor for wheel in document.wheels} == {"left"}
    # The same pictures give the same reading to the last bit.
    assert document.wheels[0].tread_wear == document.wheels[1].tread_wear


def test_results_come_back_from_their_file_as_they_were(tmp_path, folder, calibration):
    document = measure_sources([folder / "wheel0.png"], calibration)
    document.write(tmp_path / "results.json")
    assert MeasurementDocument.read(tmp_path / "results.json") == document


def test_recording_of_another_sensor_is_refused(tmp_path, views, calibration):
    (path,) = record(tmp_path / "train.mcap", [views[:1]], sensor="right")
    with pytest.raises(InputUnusable, match="of sensor right but the calibration is of left"):
        measure_sources([path], calibration)


def test_picture_of_another_size_is_refused(tmp_path, calibration):
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((10, 20), np.uint8))
    with pytest.raises(InputUnusable, match=r"small\.png is 20 x 10 px but the calibration"):
        measure_sources([tmp_path], calibration)


@pytest.mark.parametrize("reference", ["S1003", "absent.csv"])
def test_unknown_reference_is_refused_with_the_known_ones(folder, calibration, reference):
    with pytest.raises(InputUnusable, match="S1002, LMA"):
        measure_sources([folder], calibration, reference=reference)


def test_wheel_of_which_no_frame_shows_anything_is_a_row_with_a_reason(
    tmp_path, views, calibration
):
    dark = np.zeros_like(views[0])
    (path,) = record(tmp_path / "train.mcap", [views[:2], [dark, dark]])
    document = measure_sources([path], calibration)
    assert [wheel.frames for wheel in document.wheels] == [(1, 2), (3, 4)]
    assert document.wheels[1].reason is not None
