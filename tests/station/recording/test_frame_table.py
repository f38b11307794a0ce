"""Shows that a table of a recording's frames finds what reading the files anew finds; how much
quicker it is the bench says, not these tests."""

import struct

import numpy as np
import pytest
from recording_samples import make_recording, picture, write_picture

from station.errors import NotFound, RecordingUnreadable
from station.recording import FrameTable, RecordingWriter, frames, list_frames


@pytest.fixture
def parts(tmp_path, rng):
    """A recording in two files, whose camera skips some numbers."""
    paths = [tmp_path / "a.mcap", tmp_path / "a.2.mcap"]
    for path, ids in zip(paths, [(1, 2, 5), (6, 9)], strict=True):
        with RecordingWriter(path) as writer:
            for frame_id in ids:
                write_picture(writer, frame_id, picture(rng))
    return paths


def test_table_has_the_frames_of_all_files_in_order(parts):
    table = FrameTable.of(parts)
    listed = list_frames(parts, after=0, most=10)
    assert len(table) == len(listed) == 5
    assert table.frame_ids.tolist() == [each.frame_id for each in listed] == [1, 2, 5, 6, 9]
    assert table.camera_times_ns.tolist() == [each.camera_time_ns for each in listed]
    assert table.host_times_ns.tolist() == [each.host_time_ns for each in listed]


def test_each_frame_is_found_as_by_reading_the_files(parts):
    table = FrameTable.of(parts)
    expected = [frame for path in parts for frame in frames(path)]
    for number, frame in enumerate(expected, start=1):
        listed, found = table.frame(number)
        assert [listed] == list_frames(parts, after=number - 1, most=1)
        np.testing.assert_array_equal(found, frame.picture)


def test_numbers_are_told_by_the_ids_of_the_camera(parts):
    assert FrameTable.of(parts).numbers_of([9, 1, 5, 7, 99]) == {1: 1, 5: 3, 9: 5}


@pytest.mark.parametrize("number", [0, 6, -1])
def test_frame_that_is_not_there_is_told_with_how_many_there_are(parts, number):
    with pytest.raises(NotFound, match=f"has 5 frames; there is no frame {number}"):
        FrameTable.of(parts).frame(number)


def test_table_of_no_frames_is_empty(tmp_path):
    path = tmp_path / "empty.mcap"
    RecordingWriter(path).finish()
    table = FrameTable.of([path])
    assert len(table) == 0
    assert table.numbers_of([1]) == {}


def test_frame_damaged_since_the_table_was_read_is_refused(tmp_path, rng):
    path = tmp_path / "a.mcap"
    make_recording(path, rng)
    table = FrameTable.of([path])
    row = table.rows[2]
    with path.open("r+b") as stream:
        stream.seek(int(row["chunk_start"] + row["chunk_length"]) - 100)
        stream.write(b"\xff\x00" * 8)
    with pytest.raises(RecordingUnreadable, match="checksum of a chunk"):
        table.frame(3)
    assert table.frame(4)[0].number == 4


def test_time_beyond_all_clocks_is_damage(tmp_path, rng):
    path = tmp_path / "a.mcap"
    make_recording(path, rng, count=1)
    row = FrameTable.of([path]).rows[0]
    start = path.read_bytes().find(
        struct.pack("<Q", int(row["camera_time_ns"])), int(row["chunk_start"])
    )
    with path.open("r+b") as stream:
        stream.seek(start)
        stream.write(b"\xff" * 8)
    with pytest.raises(RecordingUnreadable, match="header of a frame"):
        FrameTable.of([path])
