"""Opening a finished recording: what is not one is named in one line, its summary is checked."""

import contextlib
import os
from collections.abc import Generator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    MetadataIndex,
    Schema,
    Statistics,
)
from zlib_ng.zlib_ng import crc32

from station.errors import InputUnusable, RecordingUnreadable
from station.recording.chunks import records
from station.recording.layout import DAMAGED, FOOTER_BODY, FOOTER_LENGTH, MAGIC, PREFIX

_IN_SUMMARY: dict[int, type[Any]] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.STATISTICS: Statistics,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.METADATA_INDEX: MetadataIndex,
}


@dataclass(frozen=True, slots=True)
class Recording:
    """An open recording; its summary has passed its checksum, the data has not been read."""

    path: Path
    descriptor: int
    size_bytes: int
    data_end: int
    """Where the data section ends, with its end record."""
    schemas: dict[int, Schema]
    channels: dict[int, Channel]
    chunks: tuple[ChunkIndex, ...]
    """In file order."""
    attachments: tuple[AttachmentIndex, ...]
    metadata: tuple[MetadataIndex, ...]
    statistics: Statistics

    def read(self, offset: int, length: int) -> bytes:
        """Return bytes of the file."""
        return os.pread(self.descriptor, length, offset)

    def damaged(self, where: str, error: Exception) -> RecordingUnreadable:
        """Return the error that says what is wrong, and where."""
        return RecordingUnreadable(
            f"{self.path}: damaged {where} ({error}); use a copy that "
            "`station recording verify` passes"
        )


@contextlib.contextmanager
def open_recording(path: Path) -> Generator[Recording, None, None]:
    """Open a finished recording.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is empty, not MCAP, cut short or unfinished, or its summary is damaged.
    """
    descriptor = open_file(path)
    try:
        yield _opened(path, descriptor)
    finally:
        os.close(descriptor)


def open_file(path: Path, flags: int = os.O_RDONLY) -> int:
    """Open any file that begins as MCAP does; return its descriptor."""
    try:
        descriptor = os.open(path, flags)
        start = os.pread(descriptor, len(MAGIC), 0)
    except OSError as error:
        raise InputUnusable(f"{path}: {error.strerror}; give a recording (.mcap)") from error
    try:
        _check_start(path, start, os.fstat(descriptor).st_size)
    except RecordingUnreadable:
        os.close(descriptor)
        raise
    return descriptor


def _check_start(path: Path, start: bytes, size: int) -> None:
    if size == 0:
        raise RecordingUnreadable(f"{path}: an empty file; give a recording (.mcap)")
    if start != MAGIC[: len(start)] or len(start) < len(MAGIC):
        raise RecordingUnreadable(
            f"{path}: {size} bytes that are not MCAP (they begin with {start[:8].hex(' ')}); "
            "give a recording (.mcap)"
        )
    if size <= len(MAGIC) + PREFIX.size:
        raise RecordingUnreadable(
            f"{path}: holds nothing behind the MCAP signature; the recording never began"
        )


def _opened(path: Path, descriptor: int) -> Recording:
    size = os.fstat(descriptor).st_size
    end = FOOTER_LENGTH + len(MAGIC)
    ending = os.pread(descriptor, end, max(0, size - end))
    if ending[-len(MAGIC) :] != MAGIC:
        raise RecordingUnreadable(
            f"{path}: cut short or unfinished, {size} bytes without an end; "
            f"`station recording recover {path}` makes it whole"
        )
    try:
        start, summary = _summary(descriptor, size, ending[:FOOTER_LENGTH])
        return _parsed(path, descriptor, size, start, summary)
    except DAMAGED as error:
        raise RecordingUnreadable(
            f"{path}: damaged summary ({error}); `station recording recover {path}` makes a new one"
        ) from error


def _summary(descriptor: int, size: int, footer: bytes) -> tuple[int, bytes]:
    """Return where the summary starts, and its bytes, once its checksum has passed."""
    if PREFIX.unpack_from(footer) != (Opcode.FOOTER, FOOTER_BODY.size):
        raise ValueError("no footer at its end")
    start, _, crc = FOOTER_BODY.unpack_from(footer, PREFIX.size)
    end = size - len(MAGIC) - FOOTER_LENGTH
    if start == 0:
        raise ValueError("there is none")
    if not (len(MAGIC) < start < end):
        raise ValueError(f"it starts at byte {start} of {size}")
    summary = os.pread(descriptor, end - start, start)
    if crc and crc32(footer[:-4], crc32(summary)) != crc:
        raise ValueError("its checksum does not match")
    return start, summary


def _parsed(path: Path, descriptor: int, size: int, start: int, summary: bytes) -> Recording:
    found: dict[int, list[Any]] = {opcode: [] for opcode in _IN_SUMMARY}
    for opcode, _, body in records(memoryview(summary)):
        if opcode in _IN_SUMMARY:
            found[opcode].append(_IN_SUMMARY[opcode].read(ReadDataStream(BytesIO(body))))
    if len(found[Opcode.STATISTICS]) != 1:
        raise ValueError("no statistics in it")
    return Recording(
        path=path,
        descriptor=descriptor,
        size_bytes=size,
        data_end=start,
        schemas={schema.id: schema for schema in found[Opcode.SCHEMA]},
        channels={channel.id: channel for channel in found[Opcode.CHANNEL]},
        chunks=tuple(sorted(found[Opcode.CHUNK_INDEX], key=lambda chunk: chunk.chunk_start_offset)),
        attachments=tuple(found[Opcode.ATTACHMENT_INDEX]),
        metadata=tuple(found[Opcode.METADATA_INDEX]),
        statistics=found[Opcode.STATISTICS][0],
    )
