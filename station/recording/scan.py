"""Finding what can be used in an MCAP file that may be unfinished."""

import os
import struct
from dataclasses import dataclass
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, ChunkIndex, McapRecord, Metadata, Schema
from zlib_ng.zlib_ng import crc32, crc32_combine

from station.recording.chunks import messages, read_chunk
from station.recording.index import FileIndex, IndexedChunk
from station.recording.layout import CHUNK_START, DAMAGED, MAGIC, PREFIX

_READERS: dict[int, type[Schema | Channel | Metadata | Attachment]] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.METADATA: Metadata,
    Opcode.ATTACHMENT: Attachment,
}


@dataclass(frozen=True, slots=True)
class Scan:
    """The part of a file that can be used."""

    index: FileIndex
    end: int
    """Offset behind the last whole record of the data section."""
    finished: bool
    """The data section ends with its own end record."""


def scan(descriptor: int, earlier: Scan | None = None) -> Scan:
    """Walk the records of a data section by their headers; pictures are not read.

    It stops at the first record that is cut short or makes no sense.  Checksums of chunks are
    believed, not computed: `without_damaged_tail` and `verify` compute.  Of a file that grows an
    earlier scan is gone on with; that one is of no more use then.
    """
    size = os.fstat(descriptor).st_size
    if earlier is None:
        index, at = FileIndex(), len(MAGIC)
        index.data_crc = crc32(MAGIC)
    else:
        index, at = earlier.index, earlier.end
    while at + PREFIX.size <= size:
        opcode, length = PREFIX.unpack(os.pread(descriptor, PREFIX.size, at))
        end = at + PREFIX.size + length
        if opcode == 0 or end > size:
            break
        if opcode == Opcode.DATA_END:
            return Scan(index, at, finished=True)
        try:
            _take(descriptor, index, opcode, at, length)
        except DAMAGED:
            break
        at = end
    return Scan(index, at, finished=False)


def without_damaged_tail(descriptor: int, found: Scan) -> Scan:
    """Give up the last chunks as long as they fail their checksum or lack their index.

    Only what ends the file: behind a damaged chunk that others follow, these would be given up too.
    A process killed in the middle of a write leaves at most one such chunk, a host that lost its
    power those of the last second.
    """
    index, end = found.index, found.end
    while index.end_of_last_chunk == end and not _is_whole(descriptor, index.chunks[-1]):
        last = index.chunks.pop()
        index.data_crc, end = last.crc_before, last.index.chunk_start_offset
    return Scan(index, end, found.finished)


def without_unindexed_tail(found: Scan) -> Scan:
    """Give up the last chunk where the record that says what is in it is not yet written."""
    index = found.index
    if index.chunks and not index.chunks[-1].counts:
        last = index.chunks.pop()
        index.data_crc = last.crc_before
        return Scan(index, last.index.chunk_start_offset, finished=False)
    return found


def decode(opcode: int, body: bytes) -> McapRecord:
    """Decode a schema, a channel, metadata or an attachment."""
    record: McapRecord = _READERS[opcode].read(ReadDataStream(BytesIO(body)))
    return record


def _is_whole(descriptor: int, chunk: IndexedChunk) -> bool:
    try:
        content = read_chunk(descriptor, chunk.index)
        return sum(1 for _ in messages(content)) == sum(chunk.counts.values())
    except DAMAGED:
        return False


def _take(descriptor: int, index: FileIndex, opcode: int, at: int, length: int) -> None:
    """Take note of one record, and add its bytes to the checksum of the data section."""
    if opcode == Opcode.CHUNK:
        _take_chunk(descriptor, index, at, length)
        return
    record = os.pread(descriptor, PREFIX.size + length, at)
    if opcode in _READERS:
        index.add(decode(opcode, record[PREFIX.size :]), at, len(record))
    index.data_crc = crc32(record, index.data_crc)
    if opcode == Opcode.MESSAGE_INDEX:
        _take_message_index(index, record, at)


def _take_chunk(descriptor: int, index: FileIndex, at: int, length: int) -> None:
    head = os.pread(descriptor, PREFIX.size + min(length, 256), at)
    first, last, size, crc, named = CHUNK_START.unpack_from(head, PREFIX.size)
    opening = PREFIX.size + CHUNK_START.size + named + 8
    (stored,) = struct.unpack_from("<Q", head, opening - 8)
    if opening + stored != PREFIX.size + length:
        raise ValueError("the size of a chunk contradicts its content's")
    if named or not crc:  # then the checksum in the header is not that of the stored bytes
        crc = crc32(os.pread(descriptor, stored, at + opening))
    before = index.data_crc
    index.data_crc = crc32_combine(crc32(head[:opening], before), crc, stored)
    chunk = ChunkIndex(
        message_start_time=first,
        message_end_time=last,
        chunk_start_offset=at,
        chunk_length=PREFIX.size + length,
        message_index_offsets={},
        message_index_length=0,
        compression=head[PREFIX.size + CHUNK_START.size : opening - 8].decode(),
        compressed_size=stored,
        uncompressed_size=size,
    )
    index.chunks.append(IndexedChunk(chunk, {}, before))


def _take_message_index(index: FileIndex, record: bytes, at: int) -> None:
    if not index.chunks:
        raise ValueError("a message index before any chunk")
    channel, size = struct.unpack_from("<HI", record, PREFIX.size)
    chunk, counts = index.chunks[-1].index, index.chunks[-1].counts
    chunk.message_index_offsets[channel] = at
    chunk.message_index_length += len(record)
    counts[channel] = size // 16  # an entry is a time and an offset, 8 bytes each
