"""Readings do not depend on how a recording lies on the disk: in one file, several, compacted."""

import pytest
from wheel_recordings import FILE_FOR_EACH_FRAME, record

from calib import Target
from station.errors import RecordingUnreadable
from station.pipeline import measure_sources, observe_sources, read_frames
from station.recording import compact, frames


def readings(sources, calibration):
    """All that was measured, but for the names of the files."""
    document = measure_sources(sources, calibration)
    return [wheel.model_dump(exclude={"source"}) for wheel in document.wheels]


def test_readings_are_the_same_to_the_last_bit_from_one_file_several_and_compacted(
    tmp_path, views, calibration
):
    (whole,) = record(tmp_path / "whole.mcap", [views])
    first, *later = record(tmp_path / "parts.mcap", [views], rotation=FILE_FOR_EACH_FRAME)
    assert len(later) == 2
    expected = readings([whole], calibration)
    # One wheel, though each of its pictures may lie in a file of its own.
    assert [(wheel["frames"], wheel["reason"]) for wheel in expected] == [((1, 2, 3), None)]
    assert readings([first], calibration) == expected
    assert readings([*later, first], calibration) == expected  # as a shell names them
    saved = compact(whole)
    assert readings([whole], calibration) == expected
    # Rendered wheels in daylight with their sensor's noise: what zstd makes of real ones.
    assert saved.before_bytes / saved.after_bytes > 1.3


def test_missing_file_is_named_and_nothing_is_measured(tmp_path, views, calibration):
    _, second, _ = record(tmp_path / "parts.mcap", [views], rotation=FILE_FOR_EACH_FRAME)
    second.unlink()
    with pytest.raises(RecordingUnreadable, match="goes on in parts.0002.mcap"):
        measure_sources([tmp_path / "parts.mcap"], calibration)


def test_frames_of_several_files_have_their_places_and_times_in_order(tmp_path, views):
    parts = record(tmp_path / "parts.mcap", [views], rotation=FILE_FOR_EACH_FRAME)
    found = list(read_frames([parts[0]]))
    assert [frame.number for frame in found] == [1, 2, 3]
    assert [frame.source for frame in found] == [part.name for part in parts]
    times = [frame.camera_time_ns for part in parts for frame in frames(part)]
    assert [frame.time_ns for frame in found] == times == sorted(times)


def test_target_pictures_of_several_files_are_observed_as_of_one(tmp_path, views):
    """None shows a target here; what counts is that each is looked at."""
    (whole,) = record(tmp_path / "whole.mcap", [views])
    parts = record(tmp_path / "parts.mcap", [views], rotation=FILE_FOR_EACH_FRAME)
    target = Target.parse("dots:7x8:12:d=6")
    counts = [len(observe_sources([each], target).left_out) for each in (whole, parts[0])]
    assert counts == [3, 3]
