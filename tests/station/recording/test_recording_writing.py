"""Writing: names, locks, a full disk.  Power loss is not shown: a test cannot cut it."""

import contextlib
import errno
import os
import shutil

import numpy as np
import pytest
from recording_samples import make_recording, no_file_beyond, picture, started, write_picture

from station.errors import DiskFull, InputUnusable, RecordingError, StateConflict
from station.recording import EventKind, RecordingWriter, active_path, events, frames, verify


def test_file_has_its_name_only_once_it_is_whole(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
        assert active_path(path).exists()
        assert not path.exists()
    assert path.exists()
    assert not active_path(path).exists()


def test_error_in_the_block_leaves_a_whole_recording(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with contextlib.suppress(ZeroDivisionError), RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
        raise ZeroDivisionError
    assert len(list(frames(path))) == 1


def test_recording_is_never_overwritten(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng)
    before = (tmp_path / "a.mcap").read_bytes()
    with pytest.raises(InputUnusable, match="exists"):
        RecordingWriter(tmp_path / "a.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == before


def test_recording_being_written_is_left_alone(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        with pytest.raises(InputUnusable, match="is being written or was interrupted"):
            RecordingWriter(path)
        with pytest.raises(StateConflict, match="another process"):
            RecordingWriter(path, resume=True)
        write_picture(writer, 1, picture(rng))
    assert verify(path).ok


def test_folder_that_is_not_there_is_unusable_input(tmp_path):
    with pytest.raises(InputUnusable, match="cannot be created"):
        RecordingWriter(tmp_path / "none" / "a.mcap")


def test_finishing_twice_is_finishing_once(tmp_path, rng):
    writer = RecordingWriter(tmp_path / "a.mcap")
    write_picture(writer, 1, picture(rng))
    assert writer.finish() == writer.finish()
    with pytest.raises(RecordingError, match="is finished"):
        write_picture(writer, 2, picture(rng))


def test_discarded_recording_leaves_nothing(tmp_path):
    RecordingWriter(tmp_path / "a.mcap").discard()
    assert list(tmp_path.iterdir()) == []


def test_picture_of_the_wrong_size_is_refused(tmp_path):
    with (
        RecordingWriter(tmp_path / "a.mcap") as writer,
        pytest.raises(ValueError, match="cannot be 5 bytes"),
    ):
        writer.write_frame("left", 1, 0, 0, memoryview(b"12345"), 2, 3)


def write_all(writer, pictures, first):
    for number, pixels in enumerate(pictures, first):
        write_picture(writer, number, pixels)


@pytest.mark.parametrize("spare", [0, 1, 40, 1500, 3000])
def test_full_disk_ends_the_recording_whole_and_says_so(tmp_path, rng, spare):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)
    writer.write_event("left", started())
    pictures = [picture(rng) for _ in range(20)]
    write_picture(writer, 1, pictures[0])
    with no_file_beyond(active_path(path).stat().st_size * 5 + spare):
        with pytest.raises(DiskFull, match="no space left"):
            write_all(writer, pictures[1:], first=2)
        summary = writer.finish()
    assert summary.disk_full
    report = verify(path)
    assert report.ok
    kept = list(frames(path))
    assert summary.frames == {"left": len(kept)}
    assert len(kept) >= 3
    for frame, pixels in zip(kept, pictures, strict=False):
        np.testing.assert_array_equal(frame.picture, pixels)
    assert EventKind.DISK_FULL in {event.kind for event in events(path)}
    assert summary.size_bytes == path.stat().st_size


def test_disk_full_before_the_first_frame_leaves_nothing(tmp_path):
    with no_file_beyond(2000), pytest.raises(DiskFull, match="no space left"):
        RecordingWriter(tmp_path / "a.mcap", attachments={"calibration.json": bytes(3000)})
    assert list(tmp_path.iterdir()) == []


def test_no_space_for_the_summary_gives_up_the_last_frames(tmp_path, rng):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)
    for number in range(1, 11):
        write_picture(writer, number, picture(rng))
    with no_file_beyond(active_path(path).stat().st_size + 10):
        summary = writer.finish()
    assert summary.frames == {"left": 9}
    assert verify(path).ok


def test_frames_leave_the_reserve_to_others_and_the_end_of_the_file_takes_of_it(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
    free = shutil.disk_usage(tmp_path).free
    writer = RecordingWriter(tmp_path / "b.mcap", reserve_bytes=2 * free)
    writer.write_event("left", started())
    with pytest.raises(DiskFull, match="no space left"):
        write_picture(writer, 1, picture(rng))
    assert writer.finish().disk_full
    assert [e.kind for e in events(tmp_path / "b.mcap")][-1] is EventKind.DISK_FULL


def test_disk_that_fails_is_a_recording_error(tmp_path, rng, monkeypatch):
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(path)

    def broken(*_):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patched:
        patched.setattr(os, "writev", broken)
        with pytest.raises(RecordingError, match="Input/output error"):
            write_picture(writer, 1, picture(rng))
    writer.finish()
    assert list(frames(path)) == []
