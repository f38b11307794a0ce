"""A compacted recording holds what it held, bit for bit, and any MCAP reader reads it.

How much smaller real pictures become is not shown: noise does not shrink, so these are smooth.
"""

import errno
import fcntl
import json
import os
from functools import partial

import numpy as np
import pytest
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, Writer
from recording_samples import CALIBRATION, make_recording, no_file_beyond, started, write_picture

from station.cli.main import build_app, run
from station.errors import (
    DiskFull,
    InputUnusable,
    NothingMeasurable,
    RecordingError,
    RecordingUnreadable,
    StateConflict,
)
from station.recording import (
    EventKind,
    RecordingWriter,
    active_path,
    attachment,
    compact,
    compaction,
    events,
    frames,
    info,
    is_compact,
    recover,
    verify,
)


@pytest.fixture
def pictures(rng):
    rows = np.arange(96)[:, None] // 8 + rng.integers(0, 2, (6, 96, 128))
    return rows.astype(np.uint8)


@pytest.fixture
def path(tmp_path, pictures):
    path = tmp_path / "a.mcap"
    metadata = {"camera": {"sensor": "left", "exposure_us": "250.0"}}
    with RecordingWriter(
        path, metadata=metadata, attachments={"calibration.json": CALIBRATION}
    ) as writer:
        writer.write_event("left", started())
        for number, pixels in enumerate(pictures, 1):
            write_picture(writer, number, pixels)
        write_picture(writer, 1, pictures[0], sensor="right")
        writer.write_metadata("accounting", {"recorded": "6"})
    return path


def everything(path):
    """All that a reader of another make finds, in the order of the file."""
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        messages = [
            (
                channel.topic,
                channel.message_encoding,
                schema.name,
                schema.data,
                *vars(message).items(),
            )
            for schema, channel, message in reader.iter_messages(log_time_order=False)
        ]
    with path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True)
        attachments = [vars(one) for one in summary.iter_attachments()]
        metadata = [vars(one) for one in summary.iter_metadata()]
        header = vars(summary.get_header())
    return messages, attachments, metadata, header


def test_everything_in_it_is_as_before_to_a_reader_of_another_make(path):
    before, size = everything(path), path.stat().st_size
    report = compact(path)
    assert everything(path) == before
    assert (report.before_bytes, report.after_bytes) == (size, path.stat().st_size)
    assert report.after_bytes < size / 2
    assert report.chunks == 8
    assert is_compact(path)
    assert verify(path).ok
    assert list(path.parent.iterdir()) == [path]


def test_our_own_reader_finds_the_same_frames_events_and_files(path, pictures):
    seen = info(path)
    compact(path)
    found = list(frames(path, "left"))
    np.testing.assert_array_equal([frame.picture for frame in found], pictures)
    assert {frame.exposure_us for frame in found} == {250.0}
    assert [frame.frame_id for frame in frames(path, "right")] == [1]
    assert [event.kind for event in events(path)] == [EventKind.STARTED]
    assert attachment(path, "calibration.json") == CALIBRATION
    assert (info(path).sensors, info(path).metadata) == (seen.sensors, seen.metadata)


def test_file_of_another_writer_is_compacted_too(tmp_path):
    """Channels within chunks of several messages, compressed already by another method."""
    path = tmp_path / "theirs.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=4000, compression=CompressionType.LZ4)
        writer.start()
        schema = writer.register_schema("raw", "jsonschema", b"{}")
        channels = [writer.register_channel(f"/x{n}", "json", schema) for n in range(3)]
        for number in range(300):
            text = json.dumps({"number": number, "name": "somewhere"}).encode()
            writer.add_message(channels[number % 3], number, text, number, number)
        writer.finish()
    before = everything(path)
    compact(path)
    assert everything(path) == before


def test_second_time_would_not_shrink_and_says_so(path):
    compact(path)
    before = path.read_bytes()
    with pytest.raises(NothingMeasurable, match="bytes would become .* stays as it is"):
        compact(path)
    assert path.read_bytes() == before


def test_unfinished_recording_is_refused(path):
    path.rename(active_path(path))
    active_path(path).write_bytes(active_path(path).read_bytes()[:-100])
    with pytest.raises(RecordingUnreadable, match="recording recover"):
        compact(active_path(path))
    with pytest.raises(InputUnusable, match="No such file"):
        compact(path)


def test_no_flipped_bit_is_compacted(path, rng):
    whole = path.read_bytes()
    for bit in rng.integers(0, 8 * len(whole), 100).tolist():
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        with pytest.raises(RecordingUnreadable):
            compact(path)
        assert path.read_bytes() == damaged
    assert list(path.parent.iterdir()) == [path]


def test_no_flipped_bit_of_a_compacted_recording_is_believed(path, rng):
    compact(path)
    whole = path.read_bytes()
    for bit in rng.integers(0, 8 * len(whole), 200).tolist():
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        with pytest.raises(RecordingUnreadable):
            list(frames(path))


def test_cut_compacted_recording_is_recovered(path):
    compact(path)
    path.write_bytes(path.read_bytes()[:-1200])
    report = recover(path)
    assert report.frames >= 4
    assert report.verified.ok


@pytest.mark.parametrize(("checksums", "said"), [(True, "crc"), (False, r"chunk \d differs")])
def test_new_file_that_differs_never_takes_the_old_ones_place(path, monkeypatch, checksums, said):
    """A pixel changes on its way: its checksum tells, and without checksums the comparison."""
    before = path.read_bytes()
    content_of = compaction.chunk_content
    monkeypatch.setattr(
        compaction, "read_chunk", partial(compaction.read_chunk, validate=checksums)
    )

    def altered(body, *, validate):
        content = bytearray(content_of(body, validate=validate))
        content[-20] ^= 1
        return memoryview(content)

    monkeypatch.setattr(compaction, "chunk_content", altered)
    with pytest.raises(RecordingError, match=rf"not equal .{said}.*old one is kept"):
        compact(path)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_record_that_is_lost_on_the_way_is_noticed(path, monkeypatch):
    before = path.read_bytes()
    walk = compaction._records
    skipped = iter([True])

    def shorter(recording):
        records = list(walk(recording))
        return records[:-1] if next(skipped, False) else records

    monkeypatch.setattr(compaction, "_records", shorter)
    with pytest.raises(RecordingError, match="not equal"):
        compact(path)
    assert path.read_bytes() == before


def test_full_disk_leaves_the_old_file_and_nothing_else(path):
    before = path.read_bytes()
    with no_file_beyond(2000), pytest.raises(DiskFull, match="no space for the compacted file"):
        compact(path)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_disk_that_fails_is_a_recording_error(path, monkeypatch):
    def broken(_):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", broken)
    with pytest.raises(RecordingError, match="Input/output error"):
        compact(path)
    assert list(path.parent.iterdir()) == [path]


def test_what_a_killed_compaction_left_is_written_over(path):
    left = path.with_name("a.mcap.compacting")
    left.write_bytes(bytes(10_000_000))
    compact(path)
    assert not left.exists()
    assert verify(path).ok


def test_recording_that_another_process_works_on_is_left_alone(path):
    with path.open("rb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        with pytest.raises(StateConflict, match="another process"):
            compact(path)
    compact(path)


def test_command_compacts_what_shrinks_and_exits_1_for_the_rest(path, tmp_path, rng, capsys):
    noise = tmp_path / "noise.mcap"
    make_recording(noise, rng)
    compact_already = tmp_path / "small.mcap"
    compact_already.write_bytes(path.read_bytes())
    compact(compact_already)
    arguments = ["recording", "compact", str(compact_already), str(path), "--json"]
    assert run(build_app("recording"), arguments) == 1
    said = capsys.readouterr()
    document = json.loads(said.out)
    assert [one["path"] for one in document["compacted"]] == [str(path)]
    assert len(document["left"]) == 1
    assert "stays as it is" in said.err
    assert run(build_app("recording"), ["recording", "compact", str(tmp_path / "no.mcap")]) == 2


def test_picture_that_does_not_shrink_stays_uncompressed(tmp_path, pictures, rng):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_picture(writer, 2, rng.integers(0, 256, (48, 64), dtype=np.uint8), sensor="right")
        write_picture(writer, 1, pictures[0])
    compact(path)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"", "zstd"}
