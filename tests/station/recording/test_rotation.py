"""A recording in several files: no frame is lost between them, each is whole, all belong together.

Crashes are planted where the files stand, not by killing: the capture tests kill.
"""

import os
import threading

import numpy as np
import pytest
from recording_samples import CALIBRATION, START_NS, no_file_beyond, picture, started

from station.errors import DiskFull, InputUnusable, RecordingUnreadable
from station.recording import (
    Event,
    EventKind,
    RecordingWriter,
    RotatingWriter,
    Rotation,
    active_path,
    attachment,
    events,
    frames,
    info,
    parts_of,
    recover,
    verify,
    whole_recordings,
)

METADATA = {"session": {"id": "pass-7"}, "camera": {"sensor": "left"}}


class Clock:
    """Seconds that pass as a test says."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


def writer_of(path, clock, *, seconds=1.0, size_bytes=None, **arguments):
    return RotatingWriter(
        path,
        "left",
        rotation=Rotation(seconds, size_bytes),
        metadata=METADATA,
        attachments={"calibration.json": CALIBRATION},
        clock_s=clock,
        **arguments,
    )


def write(writer, frame_id, pixels):
    height, width = pixels.shape
    writer.write_frame(
        frame_id, START_NS + frame_id, START_NS, pixels.data.cast("B"), width, height
    )


def write_all(writer, pictures, first):
    for number, pixels in enumerate(pictures, first):
        write(writer, number, pixels)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def pictures(rng):
    return [picture(rng) for _ in range(10)]


def record(path, pictures, **arguments):
    """Record with a next file due before every fourth frame."""
    clock = Clock()
    writer = writer_of(path, clock, **arguments)
    writer.write_event(started())
    for number, pixels in enumerate(pictures, 1):
        write(writer, number, pixels)
        clock.now_s += 0.35
        writer._wait_for_closing()
    return writer


def ids_in(path):
    return [frame.frame_id for frame in frames(path)]


def kinds_in(path):
    return [event.kind for event in events(path)]


def test_every_frame_is_in_one_of_the_files_in_order(path, pictures):
    summary = record(path, pictures).finish({"recorded": "10"})
    names = ["a.mcap", "a.0002.mcap", "a.0003.mcap", "a.0004.mcap"]
    assert [part.name for part in summary.paths] == names
    assert parts_of(path) == summary.paths
    assert [ids_in(part) for part in summary.paths] == [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10]]
    kept = [frame.picture for part in summary.paths for frame in frames(part)]
    np.testing.assert_array_equal(kept, pictures)
    assert summary.frames == 10


def test_every_file_is_a_whole_recording_that_says_its_place(path, pictures):
    first, second, *_, last = record(path, pictures).finish({"recorded": "10"}).paths
    for part in parts_of(path):
        assert verify(part).ok
        assert attachment(part, "calibration.json") == CALIBRATION
        assert info(part).metadata["camera"] == {"sensor": "left"}
    assert kinds_in(first) == [EventKind.STARTED, EventKind.CONTINUED_IN]
    assert kinds_in(second) == [EventKind.CONTINUED_FROM, EventKind.CONTINUED_IN]
    assert kinds_in(last) == [EventKind.CONTINUED_FROM]
    assert info(first).metadata["session"] == {"id": "pass-7"}
    assert info(second).metadata["session"] == {
        "id": "pass-7",
        "part": "2",
        "continued_from": "a.mcap",
    }
    assert info(first).metadata["accounting"] == {
        "part": "1",
        "recorded_in_part": "3",
        "continued_in": "a.0002.mcap",
    }
    assert info(last).metadata["accounting"] == {
        "recorded": "10",
        "part": "4",
        "recorded_in_part": "1",
    }


def test_recording_that_needs_one_file_is_as_without_rotation(path, pictures):
    clock = Clock()
    rotating = writer_of(path, clock, now_ns=lambda: START_NS)
    plain = RecordingWriter(
        path.with_name("b.mcap"),
        metadata=METADATA,
        attachments={"calibration.json": CALIBRATION},
        now_ns=lambda: START_NS,
    )
    rotating.write_event(started())
    plain.write_event("left", started())
    for number, pixels in enumerate(pictures, 1):
        write(rotating, number, pixels)
        view = pixels.data.cast("B")
        plain.write_frame("left", number, START_NS + number, START_NS, view, 64, 48)
    rotating.finish({"recorded": "10"})
    plain.write_metadata("accounting", {"recorded": "10"})
    plain.finish()
    assert path.read_bytes() == path.with_name("b.mcap").read_bytes()
    assert parts_of(path) == (path,)


def test_size_makes_a_next_file_too(path, pictures):
    writer = writer_of(path, Clock(), seconds=None, size_bytes=3 * pictures[0].nbytes)
    for number, pixels in enumerate(pictures, 1):
        write(writer, number, pixels)
        writer._wait_for_closing()
    assert len(writer.finish().paths) >= 3
    assert [one for part in parts_of(path) for one in ids_in(part)] == list(range(1, 11))


def test_quiet_recording_begins_no_file_without_a_frame(path, pictures):
    clock = Clock()
    writer = writer_of(path, clock)
    clock.now_s += 1000.0
    write(writer, 1, pictures[0])
    assert writer.finish().paths == (path,)


def test_writing_does_not_wait_until_the_old_file_is_on_the_disk(path, pictures, monkeypatch):
    """The disk hangs while the old file is closed; all frames are in the next one meanwhile."""
    clock = Clock()
    released, to_disk = threading.Event(), os.fsync

    def hanging(descriptor):
        if threading.current_thread().name == "close part":
            assert released.wait(10)
        to_disk(descriptor)

    monkeypatch.setattr(os, "fsync", hanging)
    writer = writer_of(path, clock)
    write(writer, 1, pictures[0])
    clock.now_s += 2.0
    for number, pixels in enumerate(pictures[1:], 2):
        write(writer, number, pixels)
    assert writer._still_closing
    assert writer._writer.frames_written("left") == 9
    threading.Timer(0.2, released.set).start()
    assert writer.finish().frames == 10


def test_next_file_that_cannot_be_begun_leaves_the_frames_in_the_present_one(
    path, pictures, monkeypatch
):
    clock = Clock()
    writer = writer_of(path, clock)
    write(writer, 1, pictures[0])
    path.with_name("a.0002.mcap").write_bytes(b"another")
    clock.now_s += 2.0
    write(writer, 2, pictures[1])
    path.with_name("a.0002.mcap").unlink()
    clock.now_s += 9.0
    write(writer, 3, pictures[2])
    clock.now_s += 2.0
    write(writer, 4, pictures[3])
    summary = writer.finish({})
    assert [ids_in(part) for part in summary.paths] == [[1, 2, 3], [4]]


def test_file_that_would_pass_for_the_second_part_is_refused_at_the_start(path, pictures):
    record(path, pictures).finish({})
    path.unlink()
    with pytest.raises(InputUnusable, match="would pass for part 2 of a.mcap"):
        writer_of(path, Clock())
    assert not active_path(path).exists()


@pytest.mark.parametrize("accounting", [None, {"recorded": "2"}])
def test_another_writer_goes_on_behind_finished_files(path, pictures, accounting):
    first = writer_of(path, Clock())
    write_all(first, pictures[:2], 1)
    first.finish(accounting)  # as whoever was killed, or was told to end
    clock = Clock()
    second = writer_of(path, clock, files_before=1)
    write(second, 3, pictures[2])
    clock.now_s += 2.0
    write(second, 4, pictures[3])
    summary = second.finish({"recorded": "4"})
    assert summary.frames == 4
    assert [ids_in(part) for part in parts_of(path)] == [[1, 2], [3], [4]]
    assert summary.paths == parts_of(path)
    with pytest.raises(InputUnusable, match="would pass for part 3 of a.mcap"):
        writer_of(path, Clock(), files_before=1)


def test_missing_part_is_named_wherever_it_is(path, pictures):
    record(path, pictures).finish({})
    for missing, before in (("a.0003.mcap", "a.0002.mcap"), ("a.0004.mcap", "a.0003.mcap")):
        away = path.with_name("away")
        path.with_name(missing).rename(away)
        with pytest.raises(RecordingUnreadable, match=f"{before} goes on in {missing}, which"):
            parts_of(path)
        away.rename(path.with_name(missing))


def test_unfinished_part_is_named_with_its_cure(path, pictures):
    record(path, pictures).finish({})
    last = path.with_name("a.0004.mcap")
    last.rename(active_path(last))
    with pytest.raises(RecordingUnreadable, match=r"recording recover .*a.0004.mcap.active"):
        parts_of(path)


def test_renamed_recording_keeps_its_parts(path, pictures):
    for number, part in enumerate(record(path, pictures).finish({}).paths, 1):
        part.rename(part.with_name("b.mcap" if number == 1 else f"b.{number:04}.mcap"))
    assert len(parts_of(path.with_name("b.mcap"))) == 4


def test_another_recording_of_a_like_name_is_no_part(path, pictures):
    writer = RecordingWriter(path, metadata=METADATA)
    writer.finish()  # without accounting, as one that was recovered
    with RecordingWriter(path.with_name("a.0002.mcap"), metadata={"session": {"id": "other"}}):
        pass
    assert parts_of(path) == (path,)


def test_files_that_a_shell_names_one_by_one_are_read_once_and_in_order(path, pictures):
    parts = record(path, pictures).finish({}).paths
    named = [*parts[1:], parts[0]]  # as a shell sorts them
    assert whole_recordings(named) == [parts]
    assert whole_recordings([parts[2]]) == [parts[2:]]


def die(writer):
    """Leave the files as a writer does that is killed: open, and without a summary."""
    writer._wait_for_closing()
    writer._writer._file.abandon()


def test_another_writer_goes_on_in_the_last_file(path, pictures):
    die(record(path, pictures[:5]))
    writer = writer_of(path, Clock(), resume=True)
    assert writer.entries_found == 6  # five frames and one event; what joins the files is no entry
    write(writer, 6, pictures[5])
    summary = writer.finish({})
    assert [ids_in(part) for part in summary.paths] == [[1, 2, 3], [4, 5, 6]]
    assert all(verify(part).ok for part in summary.paths)


@pytest.mark.parametrize("left", ["whole", "cut in the summary", "before it said where it goes on"])
def test_another_writer_closes_the_file_whose_closing_was_cut_short(path, pictures, left):
    die(record(path, pictures[:5]))
    whole = path.read_bytes()
    if left == "cut in the summary":
        whole = whole[:-300]
    if left == "before it said where it goes on":
        # Behind the picture: the rest of its message, its index of 31 bytes, a piece of the event.
        whole = whole[: whole.index(pictures[2].tobytes()) + pictures[2].nbytes + 60]
    path.unlink()
    active_path(path).write_bytes(whole)
    writer = writer_of(path, Clock(), resume=True)
    assert writer.entries_found == 6
    assert parts_of(writer.finish({}).paths[0]) == (path, path.with_name("a.0002.mcap"))
    assert ids_in(path) == [1, 2, 3]
    assert kinds_in(path)[-1] is EventKind.CONTINUED_IN
    assert EventKind.RECOVERED not in kinds_in(path)
    assert verify(path).ok


@pytest.mark.parametrize("length", [0, 8, 30])
def test_another_writer_goes_on_in_a_file_that_had_hardly_begun(path, pictures, length):
    die(record(path, pictures[:5]))
    second = active_path(path.with_name("a.0002.mcap"))
    second.write_bytes(second.read_bytes()[:length])
    writer = writer_of(path, Clock(), resume=True)
    assert writer.entries_found == 4
    write(writer, 4, pictures[3])
    assert [ids_in(part) for part in writer.finish({}).paths] == [[1, 2, 3], [4]]
    assert kinds_in(path.with_name("a.0002.mcap")) == [EventKind.CONTINUED_FROM]


def test_recovered_files_belong_together_again(path, pictures):
    die(record(path, pictures[:5]))
    path.rename(active_path(path))
    active_path(path).write_bytes(active_path(path).read_bytes()[:-400])
    for part in (path, path.with_name("a.0002.mcap")):
        recover(active_path(part))
    assert [one for part in parts_of(path) for one in ids_in(part)] == [1, 2, 3, 4, 5]


def test_full_disk_in_a_later_file_ends_it_whole(path, pictures):
    writer = record(path, pictures[:5])
    with no_file_beyond(writer._writer.size_bytes + 3500):
        with pytest.raises(DiskFull, match="no space left"):
            write_all(writer, pictures[5:], first=6)
        summary = writer.finish()
    assert summary.disk_full
    first, second = parts_of(path)
    assert ids_in(first) + ids_in(second) == list(range(1, summary.frames + 1))
    assert summary.frames in {4, 5}
    assert kinds_in(second)[-1] is EventKind.DISK_FULL
    assert verify(second).ok


@pytest.mark.parametrize("wrong", [{"seconds": 0.0}, {"seconds": float("nan")}, {"size_bytes": 0}])
def test_rotation_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(ValueError, match="more than 0"):
        Rotation(**wrong)


def test_event_that_joins_files_is_no_loss():
    event = Event(EventKind.CONTINUED_IN, 1, "a.0002.mcap")
    assert Event.from_json(event.to_json()) == event
