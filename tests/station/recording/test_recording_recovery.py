"""An unfinished or damaged recording is made whole, in place, and says what is missing."""

import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType, Writer
from recording_samples import make_recording, picture, started, write_picture

from station.errors import InputUnusable, RecordingUnreadable, StateConflict
from station.recording import (
    EventKind,
    RecordingWriter,
    active_path,
    events,
    frames,
    info,
    recover,
    verify,
)


@pytest.fixture
def interrupted(tmp_path, rng):
    """A recording's path, its pictures, and its bytes as they lie before it is finished."""
    path = tmp_path / "a.mcap"
    pictures = [picture(rng) for _ in range(8)]
    writer = RecordingWriter(path, metadata={"session": {"id": "7"}})
    writer.write_event("left", started())
    for number, pixels in enumerate(pictures, 1):
        write_picture(writer, number, pixels)
    unfinished = active_path(path).read_bytes()
    writer.discard()
    return path, pictures, unfinished


def test_every_cut_leaves_what_was_whole_before_it(interrupted, rng):
    path, pictures, unfinished = interrupted
    first_frame = unfinished.index(pictures[0].tobytes())
    for cut in rng.integers(first_frame, len(unfinished) + 1, 60).tolist():
        active_path(path).write_bytes(unfinished[:cut])
        report = recover(active_path(path))
        kept = list(frames(path))
        whole = sum(unfinished.find(one.tobytes()) + one.size + 100 < cut for one in pictures)
        assert len(kept) in {whole, whole + 1}
        for frame, pixels in zip(kept, pictures, strict=False):
            np.testing.assert_array_equal(frame.picture, pixels)
        assert report.frames == len(kept)
        assert report.verified.ok
        assert events(path)[-1].kind is EventKind.RECOVERED
        assert info(path).metadata["session"] == {"id": "7"}
        assert not active_path(path).exists()
        path.unlink()


def test_recovered_file_opens_with_other_readers(interrupted):
    path, pictures, unfinished = interrupted
    active_path(path).write_bytes(unfinished[:-1000])
    recover(active_path(path))
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        messages = list(reader.iter_messages("/left/image", log_time_order=False))
    assert len(messages) == len(pictures) - 1


def test_damaged_chunk_in_the_middle_is_hidden_and_the_others_stay(interrupted):
    path, pictures, unfinished = interrupted
    damaged = bytearray(unfinished)
    damaged[damaged.index(pictures[3].tobytes()) + 5] ^= 0x40
    active_path(path).write_bytes(damaged)
    report = recover(active_path(path))
    assert report.damaged_chunks == 1
    assert [frame.frame_id for frame in frames(path)] == [1, 2, 3, 5, 6, 7, 8]
    assert EventKind.RECOVERED in {event.kind for event in events(path)}
    # The missing id has no event that names it: the file does not claim to be complete.
    assert "between 3 and 5" in " ".join(report.verified.problems)


def test_damaged_last_picture_is_hidden_and_what_stands_behind_it_stays(tmp_path, rng):
    path = tmp_path / "a.mcap"
    last = picture(rng)
    with RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
        write_picture(writer, 2, last)
        writer.write_metadata("accounting", {"recorded": "2"})
    damaged = bytearray(path.read_bytes())
    damaged[damaged.index(last.tobytes()) + 9] ^= 1
    path.write_bytes(damaged)
    assert recover(path).damaged_chunks == 1
    assert [frame.frame_id for frame in frames(path)] == [1]
    assert info(path).metadata["accounting"] == {"recorded": "2"}


def test_page_of_zeros_at_the_end_is_cut_off(interrupted):
    path, _, unfinished = interrupted
    active_path(path).write_bytes(unfinished + bytes(8192))
    assert recover(active_path(path)).frames == 8


def test_cut_within_the_summary_loses_nothing(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng)
    whole = (tmp_path / "a.mcap").read_bytes()
    for missing in (1, 8, 30, 300):
        (tmp_path / "a.mcap").write_bytes(whole[:-missing])
        report = recover(tmp_path / "a.mcap")
        assert (report.frames, report.cut_bytes, report.verified.ok) == (5, 0, True)


def test_whole_recording_is_left_as_it_is(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng)
    whole = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "a.mcap").rename(tmp_path / "b.mcap.active")
    report = recover(tmp_path / "b.mcap.active")
    assert report.path == tmp_path / "b.mcap"
    assert report.path.read_bytes() == whole


def test_recording_in_use_is_not_touched(tmp_path, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_picture(writer, 1, picture(rng))
        with pytest.raises(StateConflict, match="being written"):
            recover(active_path(path))
    assert verify(path).ok


def test_recovery_does_not_overwrite_a_recording_of_the_final_name(interrupted):
    path, _, unfinished = interrupted
    active_path(path).write_bytes(unfinished)
    path.write_bytes(b"another")
    with pytest.raises(InputUnusable, match="move it away"):
        recover(active_path(path))
    assert path.read_bytes() == b"another"


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" + bytes(100), b"text"])
def test_file_without_anything_to_save_is_named(tmp_path, content):
    path = tmp_path / "a.mcap.active"
    path.write_bytes(content)
    with pytest.raises(RecordingUnreadable):
        recover(path)
    assert path.read_bytes() == content


def test_interrupted_file_of_the_mcap_library_is_recovered_too(tmp_path, rng):
    """Its channels stand inside the chunks, and its chunks are compressed."""
    path = tmp_path / "theirs.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=2000, compression=CompressionType.ZSTD)
        writer.start()
        schema = writer.register_schema("raw", "jsonschema", b"{}")
        channel = writer.register_channel("/x", "json", schema)
        for number in range(50):
            writer.add_message(channel, number, rng.bytes(500), number, number)
        writer.flush()
    recover(path)
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        assert len(list(reader.iter_messages(log_time_order=False))) == 50


def test_writer_goes_on_after_the_death_of_another(interrupted, rng):
    path, pictures, unfinished = interrupted
    active_path(path).write_bytes(unfinished[:-1000])
    with RecordingWriter(path, metadata={"session": {"id": "7"}}, resume=True) as writer:
        assert writer.frames_written("left") == 7
        assert writer.events_written("left") == 1
        write_picture(writer, 8, pictures[7])
        write_picture(writer, 9, pictures[0])
    assert [frame.frame_id for frame in frames(path)] == list(range(1, 10))
    assert verify(path).ok


@pytest.mark.parametrize(
    "damage", ["within the index", "between chunk and index", "in the picture"]
)
def test_writer_goes_on_before_a_last_frame_that_is_not_whole(interrupted, damage):
    path, pictures, unfinished = interrupted
    left = bytearray(unfinished)
    if damage == "in the picture":
        left[left.index(pictures[7].tobytes()) + 9] ^= 1
    else:
        # A message index of one entry is 31 bytes.
        del left[-31 if damage == "between chunk and index" else -5 :]
    active_path(path).write_bytes(left)
    with RecordingWriter(path, resume=True) as writer:
        assert writer.frames_written("left") == 7
        write_picture(writer, 8, pictures[7])
    assert [frame.frame_id for frame in frames(path)] == list(range(1, 9))
    assert verify(path).ok


@pytest.mark.parametrize("length", [0, 3, 8, 20])
def test_writer_goes_on_after_a_death_at_the_very_start(interrupted, rng, length):
    path, _, unfinished = interrupted
    active_path(path).write_bytes(unfinished[:length])
    with RecordingWriter(path, metadata={"session": {"id": "7"}}, resume=True) as writer:
        write_picture(writer, 1, picture(rng))
    assert verify(path).ok
    assert info(path).metadata == {"session": {"id": "7"}}


def test_killed_writer_loses_no_frame_that_it_wrote(tmp_path):
    script = textwrap.dedent(
        f"""
        import os, sys
        sys.path[:0] = [{str(Path(__file__).parent)!r}]
        import numpy as np
        from pathlib import Path
        from recording_samples import picture, write_picture
        from station.recording import RecordingWriter
        rng = np.random.default_rng(1)
        writer = RecordingWriter(Path({str(tmp_path)!r}) / "a.mcap")
        for number in range(1, 100_000):
            write_picture(writer, number, picture(rng))
            print(number, flush=True)
        """
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    for line in child.stdout:
        if int(line) == 200:
            child.send_signal(signal.SIGKILL)
            break
    said = [200, *(int(line) for line in child.stdout if line.endswith("\n"))]
    child.wait()
    child.stdout.close()
    report = recover(tmp_path / "a.mcap.active")
    assert report.frames >= max(said)
    assert report.verified.ok
