"""Appending to an MCAP file so that every finished write leaves a file that can be made whole.

The file is written without a buffer of our own: what was written survives the death of the process,
and the place where the next record goes is always known, so that a write cut short by a full disk
is taken back and the summary put in its place.  One message makes one chunk: a picture is larger
than a megabyte anyhow, small messages stay out of the pictures' chunks, and no message waits.
"""

import errno
import os
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mcap.opcode import Opcode
from mcap.records import ChunkIndex, Header, McapRecord
from zlib_ng.zlib_ng import crc32, crc32_combine

from station.recording.chunks import StoredMessage, messages, read_chunk
from station.recording.index import FileIndex, IndexedChunk
from station.recording.layout import CHUNK_START, MAGIC, MESSAGE_START, PREFIX, encoded
from station.recording.scan import scan, without_damaged_tail

_MESSAGE_INDEX = struct.Struct("<BQHIQQ")  # opcode, length, channel, bytes, log time, offset

NO_SPACE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""What the system says when no more can be written."""

Buffer = bytes | memoryview


@dataclass(frozen=True, slots=True)
class Message:
    """One message; its body in parts, so that a picture need not be copied to stand among them."""

    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    parts: Sequence[Buffer]


class McapAppender:
    """The data section of one open file."""

    def __init__(self, descriptor: int, index: FileIndex, end: int) -> None:
        self._descriptor = descriptor
        self._end = end
        self.index = index
        os.lseek(descriptor, end, os.SEEK_SET)

    @classmethod
    def start(cls, descriptor: int, library: str) -> "McapAppender":
        """Begin an empty file."""
        appender = cls(descriptor, FileIndex(), 0)
        appender._write([MAGIC])
        appender.index.data_crc = crc32(MAGIC)
        appender.add(Header(profile="", library=library))
        return appender

    @classmethod
    def resume(cls, descriptor: int, library: str) -> "McapAppender":
        """Go on with a file whose writer died; what it cut short is taken off."""
        found = without_damaged_tail(descriptor, scan(descriptor))
        if found.end <= len(MAGIC):  # it died before its first record
            os.ftruncate(descriptor, 0)
            return cls.start(descriptor, library)
        os.ftruncate(descriptor, found.end)
        return cls(descriptor, found.index, found.end)

    @property
    def size(self) -> int:
        """Bytes written."""
        return self._end

    def messages_on(self, channel: int | None) -> Iterator[StoredMessage]:
        """Yield the messages of a channel, read back from the file."""
        for chunk in self.index.chunks:
            if channel in chunk.counts:
                yield from messages(read_chunk(self._descriptor, chunk.index))

    def add(self, record: McapRecord) -> None:
        """Append a record at the top level: a schema, a channel, metadata, an attachment."""
        body = encoded(record)
        start = self._end
        self._write([body])
        self.index.data_crc = crc32(body, self.index.data_crc)
        self.index.add(record, start, len(body))

    def add_message(self, message: Message) -> None:
        """Append a message in a chunk of its own, checksummed and indexed."""
        start, length = self._end, sum(len(part) for part in message.parts)
        head = PREFIX.pack(Opcode.MESSAGE, MESSAGE_START.size + length) + MESSAGE_START.pack(
            message.channel,
            message.sequence & 0xFFFFFFFF,
            message.log_time_ns,
            message.publish_time_ns,
        )
        size, crc = len(head) + length, crc32(head)
        for part in message.parts:
            crc = crc32(part, crc)
        opening = _chunk_opening(message.log_time_ns, size, crc)
        pointer = _MESSAGE_INDEX.pack(
            Opcode.MESSAGE_INDEX, 2 + 4 + 16, message.channel, 16, message.log_time_ns, 0
        )
        self._write([opening + head, *message.parts, pointer])
        self._note_chunk(message, start, size, crc, opening, pointer)

    def finish(self, last: Sequence[Message] = ()) -> None:
        """Append the last messages and the summary; on a full disk earlier messages make way."""
        while True:
            try:
                return self._finish(last)
            except OSError as error:
                if error.errno not in NO_SPACE or not self._take_back_last_chunk():
                    raise

    def _finish(self, last: Sequence[Message]) -> None:
        before = len(self.index.chunks)
        try:
            for message in last:
                self.add_message(message)
            self._write([self.index.ending(self._end)])
        except OSError:
            while len(self.index.chunks) > before:
                self._take_back_last_chunk()
            raise

    def _take_back_last_chunk(self) -> bool:
        """Cut the last chunk off the file, unless other records stand behind it."""
        if not self.index.chunks or self.index.end_of_last_chunk != self._end:
            return False
        chunk = self.index.chunks.pop()
        self._end = chunk.index.chunk_start_offset
        self.index.data_crc = chunk.crc_before
        self._cut()
        return True

    def _note_chunk(
        self, message: Message, start: int, size: int, crc: int, opening: bytes, pointer: bytes
    ) -> None:
        index = ChunkIndex(
            message_start_time=message.log_time_ns,
            message_end_time=message.log_time_ns,
            chunk_start_offset=start,
            chunk_length=len(opening) + size,
            message_index_offsets={message.channel: start + len(opening) + size},
            message_index_length=len(pointer),
            compression="",
            compressed_size=size,
            uncompressed_size=size,
        )
        before = self.index.data_crc
        after = crc32_combine(crc32(opening, before), crc, size)
        self.index.data_crc = crc32(pointer, after)
        self.index.chunks.append(IndexedChunk(index, {message.channel: 1}, before))

    def _write(self, parts: Sequence[Buffer]) -> None:
        """Write all parts or, failing, none."""
        left = [memoryview(part) for part in parts]
        total = sum(len(part) for part in left)
        try:
            while left:
                left = _after(left, os.writev(self._descriptor, left))
        except OSError:
            self._cut()
            raise
        self._end += total

    def _cut(self) -> None:
        os.ftruncate(self._descriptor, self._end)
        os.lseek(self._descriptor, self._end, os.SEEK_SET)


def _chunk_opening(time_ns: int, size: int, crc: int) -> bytes:
    start = CHUNK_START.pack(time_ns, time_ns, size, crc, 0) + struct.pack("<Q", size)
    return PREFIX.pack(Opcode.CHUNK, len(start) + size) + start


def _after(parts: list[memoryview], written: int) -> list[memoryview]:
    """Return what is left of the parts once the first `written` bytes are gone."""
    left = []
    for part in parts:
        taken = min(written, len(part))
        written -= taken
        if taken < len(part):
            left.append(part[taken:])
    return left
