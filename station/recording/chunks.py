"""The records inside a chunk, without copying them."""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex
from mcap.stream_reader import get_chunk_data_stream
from zlib_ng.zlib_ng import crc32

from station.recording.layout import CHUNK_START, MESSAGE_START, PREFIX


@dataclass(frozen=True, slots=True)
class StoredMessage:
    """A message as it lies in a chunk; `offset` is its place there, `data` a view of its body."""

    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    data: memoryview
    offset: int


def read_chunk(descriptor: int, chunk: ChunkIndex, *, validate: bool = True) -> memoryview:
    """Return the records of a chunk, uncompressed.

    Raises
    ------
    ValueError or McapError
        Where there is no chunk at the place, or its checksum fails.
    """
    record = os.pread(descriptor, chunk.chunk_length, chunk.chunk_start_offset)
    if len(record) != chunk.chunk_length or record[0] != Opcode.CHUNK:
        raise ValueError("no chunk where the index says")
    return chunk_content(memoryview(record)[PREFIX.size :], validate=validate)


def chunk_content(body: memoryview, *, validate: bool) -> memoryview:
    """Return the records in the body of a chunk record; ValueError where its checksum fails."""
    _, _, size, crc, named = CHUNK_START.unpack_from(body)
    if named:
        chunk = Chunk.read(ReadDataStream(BytesIO(body)))
        stream, length = get_chunk_data_stream(chunk, validate_crc=validate)
        return memoryview(stream.read(length))
    (stored,) = struct.unpack_from("<Q", body, CHUNK_START.size)
    content = body[CHUNK_START.size + 8 :]
    if not (len(content) == size == stored):
        raise ValueError("the size of a chunk contradicts its content's")
    if validate and crc and crc32(content) != crc:
        raise ValueError("the checksum of a chunk does not match")
    return content


def records(content: memoryview) -> Iterator[tuple[int, int, memoryview]]:
    """Yield (opcode, offset, body) of the records in a chunk."""
    at = 0
    while at < len(content):
        opcode, length = PREFIX.unpack_from(content, at)
        body = content[at + PREFIX.size : at + PREFIX.size + length]
        if len(body) != length:
            raise ValueError("a record runs past the end of its chunk")
        yield opcode, at, body
        at += PREFIX.size + length


def messages(content: memoryview) -> Iterator[StoredMessage]:
    """Yield the messages in a chunk."""
    for opcode, at, body in records(content):
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = MESSAGE_START.unpack_from(body)
            data = body[MESSAGE_START.size :]
            yield StoredMessage(channel, sequence, log_time, publish_time, data, at)
