"""Readings do not depend on how a recording lies on the disk: in one file, several, compacted."""

from datetime import UTC, datetime

import numpy as np
import pytest

from calib import Target
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.errors import RecordingUnreadable
from station.pipeline import measure_sources, observe_sources, read_frames
from station.recording import RotatingWriter, Rotation, compact, frames
from station.scenes import WheelScene, WheelTruth, trackside_mounting

WHEEL = WheelTruth("S1002", tread_wear_mm=2.5, flange_wear_mm=1.5)
ONE_FILE = Rotation()
SEVERAL = Rotation(size_bytes=1)


@pytest.fixture(scope="module")
def calibration(truth):
    mounting = trackside_mounting("left")
    a, b, c, d = truth.plane.coefficients.tolist()
    return CalibrationDocument(
        sensor="left",
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software="none",
        method="joint",
        camera=CameraDocument.from_model(truth.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=((0.0,) * 4,) * 4,
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
        for x in (-20.0, 0.0, 15.0)
    ]


def record(path, pictures, rotation):
    """Record the pictures 10 ms apart, as those of one wheel."""
    writer = RotatingWriter(path, "left", rotation=rotation, metadata={"session": {"id": "p"}})
    for number, picture in enumerate(pictures, 1):
        height, width = picture.shape
        time_ns = 1_700_000_000_000_000_000 + number * 10_000_000
        writer.write_frame(number, time_ns, time_ns, picture.data.cast("B"), width, height)
        writer._wait_for_closing()
    return writer.finish({}).paths


def readings(sources, calibration):
    """All that was measured, but for the names of the files."""
    document = measure_sources(sources, calibration)
    return [wheel.model_dump(exclude={"source"}) for wheel in document.wheels]


def test_readings_are_the_same_to_the_last_bit_from_one_file_several_and_compacted(
    tmp_path, pictures, calibration
):
    (whole,) = record(tmp_path / "whole.mcap", pictures, ONE_FILE)
    first, *later = record(tmp_path / "parts.mcap", pictures, SEVERAL)
    assert len(later) == 2
    expected = readings([whole], calibration)
    assert any(wheel["profile"] for wheel in expected)
    assert readings([first], calibration) == expected
    assert readings([*later, first], calibration) == expected  # as a shell names them
    saved = compact(whole)
    assert readings([whole], calibration) == expected
    # Rendered wheels in daylight with their sensor's noise: what zstd makes of real ones.
    assert saved.before_bytes / saved.after_bytes > 1.3


def test_missing_file_is_named_and_nothing_is_measured(tmp_path, pictures, calibration):
    _, second, _ = record(tmp_path / "parts.mcap", pictures, SEVERAL)
    second.unlink()
    with pytest.raises(RecordingUnreadable, match="goes on in parts.0002.mcap"):
        measure_sources([tmp_path / "parts.mcap"], calibration)


def test_frames_of_several_files_have_their_places_and_times_in_order(tmp_path, pictures):
    parts = record(tmp_path / "parts.mcap", pictures, SEVERAL)
    found = list(read_frames([parts[0]]))
    assert [frame.number for frame in found] == [1, 2, 3]
    assert [frame.source for frame in found] == [part.name for part in parts]
    times = [frame.camera_time_ns for part in parts for frame in frames(part)]
    assert [frame.time_ns for frame in found] == times == sorted(times)


def test_target_pictures_of_several_files_are_observed_as_of_one(tmp_path, pictures):
    """None shows a target here; what counts is that each is looked at."""
    (whole,) = record(tmp_path / "whole.mcap", pictures, ONE_FILE)
    parts = record(tmp_path / "parts.mcap", pictures, SEVERAL)
    target = Target.parse("dots:7x8:12:d=6")
    counts = [len(observe_sources([each], target).left_out) for each in (whole, parts[0])]
    assert counts == [3, 3]
