"""Finding single frames of a recording by their place in it, without reading the others.

The index of a file says in which chunk a frame lies; of a chunk that is not compressed only the few
bytes of a frame's header are read.  So a page of frames costs the same at the end of a recording of
10 GB as at its begin, but for the file's index.
"""

import struct
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import ChunkIndex

from station.recording.chunks import StoredMessage, messages, read_chunk
from station.recording.layout import CHUNK_START, DAMAGED, MESSAGE_START, PREFIX
from station.recording.opening import Recording, open_recording
from station.recording.topics import Topic, channels_of

_INDEX_START = struct.Struct("<HI")  # of a message index: channel, bytes of its entries
_ENTRY = struct.Struct("<QQ")  # log time, offset in the chunk
_STORED_SIZE = 8
_LARGEST_CHUNK_BYTES = 128 << 20
"""Our own hold one large picture; whoever shows one frame has no memory for everything."""
Entry = tuple[int, int]
"""Offset in the chunk, channel."""


@dataclass(frozen=True, slots=True)
class ListedFrame:
    """A frame of a recording, without its picture."""

    number: int
    """Its place in the recording, from 1, whatever the camera calls it."""
    sensor: str
    frame_id: int
    """As the camera numbers them."""
    camera_time_ns: int
    """When it was exposed, UTC."""
    host_time_ns: int
    """When it was received, by the host's clock, UTC."""


def list_frames(files: Sequence[Path], *, after: int, most: int) -> list[ListedFrame]:
    """Return frames of a recording in the order they were written, from those behind `after`.

    Parameters
    ----------
    files
        All files of the recording, in order.
    after
        Number of the last frame not wanted; 0 begins with the first.
    most
        How many at most.

    Raises
    ------
    InputUnusable
        If a file is not there.
    RecordingUnreadable
        If one is no whole recording, or damaged where a frame is looked for.
    """
    return list(islice(_listed(files, after), most))


def _listed(files: Sequence[Path], after: int) -> Iterator[ListedFrame]:
    before = 0
    for path in files:
        with open_recording(path) as recording:
            count = _frames_in(recording)
            if after < before + count:
                yield from _listed_in(recording, before, after)
            before += count


def _listed_in(recording: Recording, before: int, after: int) -> Iterator[ListedFrame]:
    for first, chunk, entries in chunks_with_frames(recording, before):
        if first + len(entries) <= after:
            continue
        headers = headers_of(recording, chunk, entries)
        for number, header in enumerate(headers, start=first + 1):
            if number > after:
                yield as_listed(recording, number, header)


def as_listed(recording: Recording, number: int, message: StoredMessage) -> ListedFrame:
    """Return the frame that a message of a recording holds, without its picture."""
    sensors = channels_of(recording.channels.values(), Topic.IMAGE)
    return ListedFrame(
        number=number,
        sensor=sensors[message.channel],
        frame_id=message.sequence,
        camera_time_ns=message.publish_time_ns,
        host_time_ns=message.log_time_ns,
    )


def _frames_in(recording: Recording) -> int:
    counts = recording.statistics.channel_message_counts
    channels = channels_of(recording.channels.values(), Topic.IMAGE)
    return sum(counts.get(channel, 0) for channel in channels)


def chunks_with_frames(
    recording: Recording, before: int
) -> Iterator[tuple[int, ChunkIndex, Sequence[Entry]]]:
    """Yield the frames before a chunk, the chunk, and where its frames lie in it."""
    channels = channels_of(recording.channels.values(), Topic.IMAGE).keys()
    for chunk in recording.chunks:
        try:
            entries = sorted(_entries(recording, chunk, channels))
        except DAMAGED as error:
            raise recording.damaged(f"at byte {chunk.chunk_start_offset}", error) from error
        if entries:
            yield before, chunk, entries
            before += len(entries)


def _entries(recording: Recording, chunk: ChunkIndex, channels: Collection[int]) -> Iterator[Entry]:
    if not chunk.message_index_offsets:  # other writers may leave it out
        found = messages(_content(recording, chunk))
        yield from ((each.offset, each.channel) for each in found if each.channel in channels)
        return
    for channel, at in chunk.message_index_offsets.items():
        if channel in channels:
            start = recording.read(at, PREFIX.size + _INDEX_START.size)
            opcode, _ = PREFIX.unpack_from(start)
            named, size = _INDEX_START.unpack_from(start, PREFIX.size)
            if opcode != Opcode.MESSAGE_INDEX or named != channel:
                raise ValueError("no index of its messages where the summary says")
            if size > chunk.message_index_length:
                raise ValueError("the index of its messages is longer than the summary says")
            listed = recording.read(at + len(start), size)
            yield from ((offset, channel) for _, offset in _ENTRY.iter_unpack(listed))


def _content(recording: Recording, chunk: ChunkIndex) -> memoryview:
    """Return what a chunk holds, once its checksum has passed."""
    size = max(chunk.uncompressed_size, chunk.chunk_length)
    if size > _LARGEST_CHUNK_BYTES:
        raise ValueError(f"a chunk of {size} bytes; at most {_LARGEST_CHUNK_BYTES} are looked into")
    return read_chunk(recording.descriptor, chunk)


def headers_of(
    recording: Recording, chunk: ChunkIndex, entries: Sequence[Entry]
) -> Iterator[StoredMessage]:
    """Yield messages without their bodies."""
    try:
        if chunk.compression:
            content = _content(recording, chunk)
            yield from (_header(content[at:], at) for at, _ in entries)
            return
        start = chunk.chunk_start_offset + PREFIX.size + CHUNK_START.size + _STORED_SIZE
        for at, _ in entries:
            length = PREFIX.size + MESSAGE_START.size
            yield _header(memoryview(recording.read(start + at, length)), at)
    except DAMAGED as error:
        raise recording.damaged(f"at byte {chunk.chunk_start_offset}", error) from error


def _header(record: memoryview, at: int) -> StoredMessage:
    opcode, _ = PREFIX.unpack_from(record)
    if opcode != Opcode.MESSAGE:
        raise ValueError("no message where its index says")
    channel, sequence, log_time, publish_time = MESSAGE_START.unpack_from(record, PREFIX.size)
    return StoredMessage(channel, sequence, log_time, publish_time, memoryview(b""), at)


def message_at(recording: Recording, chunk: ChunkIndex, entry: Entry) -> StoredMessage:
    """Return a message with its body, once the checksum of its chunk has passed."""
    try:
        content = _content(recording, chunk)
        return next(each for each in messages(content) if each.offset == entry[0])
    except (*DAMAGED, StopIteration) as error:
        raise recording.damaged(f"at byte {chunk.chunk_start_offset}", error) from error
