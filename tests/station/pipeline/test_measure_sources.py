"""Frames of wheels become rows of results, measured or with a reason; misfits are refused."""

from datetime import UTC, datetime

import cv2
import numpy as np
import pytest

from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MeasurementDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.errors import InputUnusable
from station.pipeline import measure_sources
from station.recording import RecordingWriter
from station.scenes import WheelScene, WheelTruth, trackside_mounting

WHEEL = WheelTruth("S1002", tread_wear_mm=2.5, flange_wear_mm=1.5)


@pytest.fixture(scope="module")
def calibration(truth):
    mounting = trackside_mounting("left")
    a, b, c, d = truth.plane.coefficients.tolist()
    zero = (0.0,) * 4
    return CalibrationDocument(
        sensor="left",
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software="none",
        method="joint",
        camera=CameraDocument.from_model(truth.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=(zero,) * 4,
        rms=RmsDocument(dots_px=0.0, stripe_px=0.0),
        poses=(),
        quality={},
        options={},
        inputs=(),
        mounting=MountingDocument(
            rotation_vector=tuple(mounting.rotation_vector.tolist()),
            translation_mm=tuple(mounting.translation_mm.tolist()),
        ),
    )


@pytest.fixture(scope="module")
def pictures(truth):
    rng = np.random.default_rng(3)
    return [
        WheelScene(truth, trackside_mounting("left"), WHEEL, axle_offset_mm=x, seed=7).render(rng)
        for x in (-20.0, 0.0)
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, pictures):
    folder = tmp_path_factory.mktemp("wheels")
    for index, picture in enumerate([*pictures, np.zeros_like(pictures[0])]):
        cv2.imwrite(str(folder / f"wheel{index}.png"), picture)
    return folder


def record(path, pictures, sensor, gaps_ms):
    time_ns = 1_700_000_000_000_000_000
    with RecordingWriter(path) as writer:
        for index, (picture, gap_ms) in enumerate(zip(pictures, gaps_ms, strict=True), start=1):
            time_ns += gap_ms * 1_000_000
            height, width = picture.shape
            writer.write_frame(
                sensor,
                frame_id=index,
                camera_time_ns=time_ns,
                host_time_ns=time_ns,
                picture=memoryview(picture).cast("B"),
                width=width,
                height=height,
            )
    return path


def test_every_picture_is_a_wheel_and_a_dark_one_a_row_with_a_reason(folder, calibration):
    document = measure_sources([folder], calibration)
    assert [wheel.source for wheel in document.wheels] == [f"wheel{i}.png" for i in range(3)]
    assert [wheel.reason is None for wheel in document.wheels] == [True, True, False]
    assert [wheel.frame for wheel in document.wheels] == [0, 1, 2]
    assert document.wheels[2].tread_wear.value is None
    assert document.wheels[2].tread_wear.status == "missing"
    for wheel in document.wheels[:2]:
        # What is asked of a reading in good light with the true sensor, three times over for one.
        assert wheel.tread_wear.value == pytest.approx(WHEEL.readings.tread_wear, abs=0.06)


def test_close_frames_of_a_recording_are_one_wheel(tmp_path, pictures, calibration):
    path = record(tmp_path / "train.mcap", [*pictures, *pictures], "left", [0, 20, 500, 20])
    document = measure_sources([path], calibration)
    assert [wheel.frames for wheel in document.wheels] == [(1, 2), (3, 4)]
    assert {wheel.sensor for wheel in document.wheels} == {"left"}
    # The same pictures give the same reading to the last bit.
    assert document.wheels[0].tread_wear == document.wheels[1].tread_wear


def test_results_come_back_from_their_file_as_they_were(tmp_path, folder, calibration):
    document = measure_sources([folder / "wheel0.png"], calibration)
    document.write(tmp_path / "results.json")
    assert MeasurementDocument.read(tmp_path / "results.json") == document


def test_recording_of_another_sensor_is_refused(tmp_path, pictures, calibration):
    path = record(tmp_path / "train.mcap", pictures[:1], "right", [0])
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
    tmp_path, pictures, calibration
):
    dark = np.zeros_like(pictures[0])
    path = record(tmp_path / "train.mcap", [*pictures, dark, dark], "left", [0, 20, 500, 20])
    document = measure_sources([path], calibration)
    assert [wheel.frames for wheel in document.wheels] == [(1, 2), (3, 4)]
    assert document.wheels[1].reason is not None
