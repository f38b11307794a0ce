"""Shows what is read of a recording while it is written: each frame once, in order, as soon as it
is whole, through files that follow each other, and after a crash only what the file still has."""

import os

import numpy as np
import pytest
from recording_samples import make_recording, picture, started, write_picture

from station.errors import RecordingUnreadable
from station.recording import (
    BEGINNING,
    FilePlace,
    GrowingRecording,
    RecordingWriter,
    RotatingWriter,
    Rotation,
    active_path,
    frames,
    has_place,
    parts_of,
    recover,
)

EACH_ITS_FILE = Rotation(size_bytes=1)


def numbers(found):
    return [frame.frame_id for _, frame in found]


def write_to(writer, number, pixels):
    height, width = pixels.shape
    writer.write_frame(number, number * 10**7, number * 10**7, pixels.data.cast("B"), width, height)
    writer._wait_for_closing()


def test_frames_are_there_as_soon_as_they_are_written(tmp_path, rng):
    path = tmp_path / "a.mcap"
    growing = GrowingRecording(path)
    assert growing.read(9) == []
    with RecordingWriter(path) as writer:
        writer.write_event("left", started())
        assert growing.read(9) == []
        for number in (1, 2, 3):
            pixels = picture(rng)
            write_picture(writer, number, pixels)
            ((place, frame),) = growing.read(9)
            assert frame.frame_id == number
            np.testing.assert_array_equal(frame.picture, pixels)
            assert place.frames == number - 1
            assert growing.read(9) == []
        assert growing.end is None
    assert growing.read(9) == []
    assert growing.end.frames == 3
    growing.close()


def test_no_more_is_read_than_asked_for(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng, count=5)
    growing = GrowingRecording(tmp_path / "a.mcap")
    assert [numbers(growing.read(2)) for _ in range(4)] == [[1, 2], [3, 4], [5], []]
    growing.close()


def test_what_is_cut_anywhere_is_not_there_until_it_is_whole(tmp_path, rng):
    """Each byte of a file appears by itself; frames come whole, in order, and only once."""
    make_recording(tmp_path / "whole.mcap", rng, count=3)
    content = (tmp_path / "whole.mcap").read_bytes()
    found = []
    growing = GrowingRecording(tmp_path / "a.mcap")
    with active_path(tmp_path / "a.mcap").open("wb", buffering=0) as stream:
        for at in range(0, len(content), 7):
            stream.write(content[at : at + 7])
            found += growing.read(9)
    growing.close()
    whole = list(frames(tmp_path / "whole.mcap"))
    assert numbers(found) == [1, 2, 3]
    for (_, one), other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one.picture, other.picture)


def test_a_recording_is_followed_into_its_next_files(tmp_path, rng):
    path = tmp_path / "a.mcap"
    writer = RotatingWriter(path, "left", rotation=EACH_ITS_FILE)
    growing, found = GrowingRecording(path), []
    for number in range(1, 6):
        write_to(writer, number, picture(rng))
        found += growing.read(9)
    writer.finish({})
    assert numbers(found) == [1, 2, 3, 4, 5]
    assert len(parts_of(path)) == 5
    assert [place.part for place, _ in found] == [1, 2, 3, 4, 5]
    assert growing.read(9) == []
    assert growing.end == FilePlace(5, found[-1][0].offset_bytes + 1, 5)
    assert all(has_place(path, place) for place, _ in found)
    assert has_place(path, growing.end)
    growing.close()


@pytest.mark.parametrize("rotation", [Rotation(), EACH_ITS_FILE])
def test_reading_is_taken_up_at_any_place(tmp_path, rng, rotation):
    path = tmp_path / "a.mcap"
    writer = RotatingWriter(path, "left", rotation=rotation)
    growing = GrowingRecording(path)
    for number in range(1, 5):
        write_to(writer, number, picture(rng))
    found = growing.read(9)
    growing.close()
    for place, frame in found:
        again = GrowingRecording(path, place)
        assert numbers(again.read(9)) == list(range(frame.frame_id, 5))
        assert again.read(9) == []
        again.close()
    writer.finish({})


def test_a_recorder_that_takes_over_a_cut_file_is_followed_on(tmp_path, rng):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)
    write_picture(writer, 1, picture(rng))
    growing = GrowingRecording(path)
    assert numbers(growing.read(9)) == [1]
    writer._file.abandon()
    with active_path(path).open("ab") as stream:
        stream.write(b"\x06half a chunk")
    assert growing.read(9) == []
    with RecordingWriter(path, resume=True) as writer:
        write_picture(writer, 2, picture(rng))
        assert numbers(growing.read(9)) == [2]
    growing.close()


def test_a_writer_that_takes_back_what_was_there_is_followed_no_more(tmp_path, rng):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)
    write_picture(writer, 1, picture(rng))
    growing = GrowingRecording(path)
    growing.read(9)
    os.truncate(active_path(path), 100)
    with pytest.raises(RecordingUnreadable, match="cut from .* to 100 bytes while it was followed"):
        growing.read(9)
    growing.close()
    writer._file.abandon()


def test_a_damaged_frame_is_not_read(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
        with active_path(path).open("r+b") as stream:
            stream.seek(-100, 2)
            (byte,) = stream.read(1)
            stream.seek(-100, 2)
            stream.write(bytes([byte ^ 1]))
        growing = GrowingRecording(path)
        with pytest.raises(RecordingUnreadable, match="damaged"):
            growing.read(9)
        growing.close()


def test_a_mended_recording_has_lost_the_places_behind_its_cut(tmp_path, rng):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)
    for number in (1, 2, 3):
        write_picture(writer, number, picture(rng))
    growing = GrowingRecording(path)
    places = [place for place, _ in growing.read(9)]
    growing.close()
    writer._file.abandon()
    os.truncate(active_path(path), places[1].offset_bytes + 50)
    recover(active_path(path))
    assert [has_place(path, place) for place in places] == [True, True, False]
    assert has_place(path, BEGINNING)
    assert not has_place(path, FilePlace(2, 8, 1))


@pytest.mark.parametrize("wrong", [{"part": 0}, {"offset_bytes": -1}, {"frames": -1}])
def test_a_place_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match="no place in a recording"):
        FilePlace(**wrong)
