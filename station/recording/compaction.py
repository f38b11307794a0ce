"""Making a finished recording smaller without losing a bit of it.

Each chunk is compressed by plain zstd, which every MCAP reader reads; all other records stay as
they are, in their order.  The new file is read back from the disk and held against the old one
before it takes its place.
"""

import fcntl
import os
import struct
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from zlib_ng.zlib_ng import crc32
from zstandard import STRATEGY_FAST, ZstdCompressionParameters, ZstdCompressor

from station.errors import (
    DiskFull,
    NothingMeasurable,
    RecordingError,
    RecordingUnreadable,
    StateConflict,
)
from station.progress import Progress, silent
from station.recording.activefile import sync_folder
from station.recording.appender import NO_SPACE, McapAppender
from station.recording.chunks import chunk_content, read_chunk
from station.recording.layout import CHUNK_START, DAMAGED, MAGIC, PREFIX
from station.recording.opening import Recording, open_recording
from station.recording.scan import scan
from station.recording.soundness import ensure_sound_around_chunks

_SUFFIX = ".compacting"
_ZSTD = b"zstd"
_END_LENGTH = PREFIX.size + 4

# Found by trying on pictures of stripes and targets: a noisy background has few matches, and all
# are short or whole rows; what a larger table finds does not pay for its cache misses.
_PARAMETERS = {"window_log": 19, "hash_log": 6, "chain_log": 6, "min_match": 7}


@dataclass(frozen=True, slots=True)
class CompactReport:
    """What compacting saved."""

    path: Path
    before_bytes: int
    after_bytes: int
    chunks: int
    """Chunks that were proved equal."""

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {
            "path": str(self.path),
            "before_bytes": self.before_bytes,
            "after_bytes": self.after_bytes,
            "chunks": self.chunks,
        }


def compact(path: Path, progress: Progress = silent) -> CompactReport:
    """Rewrite a finished recording in zstd, prove the new file equal, and put it in place.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is not a whole recording, or damaged anywhere.
    NothingMeasurable
        If it would not become smaller; it is left as it is.
    StateConflict
        If another process works on it.
    DiskFull
        If there is no space for the new file beside the old one.
    """
    with open_recording(path) as recording:
        _lock(recording)
        ensure_sound_around_chunks(recording)
        with _temporary(recording) as (descriptor, temporary):
            _rewrite(recording, descriptor, lambda part: progress(0.5 * part, "compress"))
            after = os.fstat(descriptor).st_size
            if after >= recording.size_bytes:
                raise NothingMeasurable(
                    f"{path}: {recording.size_bytes} bytes would become {after}; it stays as it is"
                )
            _prove(recording, temporary, lambda part: progress(0.5 + 0.5 * part, "prove"))
            temporary.rename(path)
            sync_folder(path.parent)
        return CompactReport(path, recording.size_bytes, after, len(recording.chunks))


def is_compact(path: Path) -> bool:
    """Whether a finished recording has been compacted."""
    with open_recording(path) as recording:
        return any(chunk.compression == _ZSTD.decode() for chunk in recording.chunks)


def _lock(recording: Recording) -> None:
    """Keep other processes from recovering or compacting the file meanwhile."""
    try:
        fcntl.flock(recording.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        present = recording.path.stat().st_ino == os.fstat(recording.descriptor).st_ino
    except (BlockingIOError, FileNotFoundError):
        present = False
    if not present:  # locked by another process, or replaced by one before the lock was ours
        raise StateConflict(
            f"{recording.path}: another process works on it; wait until it has finished"
        )


@contextmanager
def _temporary(recording: Recording) -> Generator[tuple[int, Path], None, None]:
    """Open the file to be; it is gone afterwards unless it has been renamed."""
    path = recording.path.with_name(recording.path.name + _SUFFIX)
    mode = os.fstat(recording.descriptor).st_mode & 0o777
    try:
        # Whoever holds the lock of the recording may write over what a killed process left.
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, mode)
    except OSError as error:
        raise RecordingError(f"{path} cannot be created: {error.strerror}") from error
    try:
        yield descriptor, path
    except OSError as error:
        if error.errno in NO_SPACE:
            raise DiskFull(
                f"{recording.path}: no space for the compacted file beside it; free some first"
            ) from error
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error
    finally:
        os.close(descriptor)
        path.unlink(missing_ok=True)


def _rewrite(recording: Recording, descriptor: int, report: Callable[[float], None]) -> None:
    """Write all records, chunks compressed, then the summary; put it on the disk."""
    compressor = ZstdCompressor(
        compression_params=ZstdCompressionParameters(
            strategy=STRATEGY_FAST, write_content_size=1, **_PARAMETERS
        )
    )
    with os.fdopen(os.dup(descriptor), "wb", buffering=1 << 20) as out:
        out.write(MAGIC)
        for opcode, at, length in _records(recording):
            record = recording.read(at, length)
            out.write(_compressed(recording, record, at, compressor) if opcode else record)
            report(at / recording.size_bytes)
    found = scan(descriptor)
    found.index.schemas.update(recording.schemas)  # other writers put them into the chunks
    found.index.channels.update(recording.channels)
    McapAppender(descriptor, found.index, found.end).finish()
    os.fsync(descriptor)


def _records(recording: Recording) -> Iterator[tuple[bool, int, int]]:
    """Yield (is a chunk, offset, length) of the records of the data section but its end."""
    at, end = len(MAGIC), recording.data_end - _END_LENGTH
    while at < end:
        opcode, length = PREFIX.unpack(recording.read(at, PREFIX.size))
        yield opcode == Opcode.CHUNK, at, PREFIX.size + length
        at += PREFIX.size + length


def _compressed(recording: Recording, record: bytes, at: int, compressor: ZstdCompressor) -> bytes:
    """Return a chunk record compressed, or as it is where that makes it no smaller."""
    body = memoryview(record)[PREFIX.size :]
    try:
        content = chunk_content(body, validate=True)
    except DAMAGED as error:
        raise recording.damaged(f"at byte {at}", error) from error
    stored = compressor.compress(content)
    if len(stored) >= len(record) - PREFIX.size - CHUNK_START.size - 8:
        return record
    first, last, size, crc, _ = CHUNK_START.unpack_from(body)
    start = CHUNK_START.pack(first, last, size, crc or crc32(content), len(_ZSTD))
    start += _ZSTD + struct.pack("<Q", len(stored))
    return PREFIX.pack(Opcode.CHUNK, len(start) + len(stored)) + start + stored


def _prove(old: Recording, temporary: Path, report: Callable[[float], None]) -> None:
    """Read the new file back, as any reader does, and hold all of it against the old one."""
    try:
        with open_recording(temporary) as new:
            # From the disk, not from what the system remembers of the writing.
            os.posix_fadvise(new.descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
            ensure_sound_around_chunks(new)
            _compare_summaries(old, new)
            _compare_records(old, new)
            for place, (before, after) in enumerate(zip(old.chunks, new.chunks, strict=True)):
                # As bytes: views are compared one by one, twenty times slower.
                content = bytes(read_chunk(old.descriptor, before))
                if content != bytes(read_chunk(new.descriptor, after)):
                    raise ValueError(f"chunk {place} differs")  # noqa: TRY301  one way out
                report(place / len(old.chunks))
    except (*DAMAGED, RecordingUnreadable) as error:
        raise RecordingError(
            f"{old.path}: the compacted file is not equal ({error}); the old one is kept: check "
            "the disk, then try again"
        ) from error


def _compare_summaries(old: Recording, new: Recording) -> None:
    same = (
        old.schemas == new.schemas,
        old.channels == new.channels,
        old.statistics == new.statistics,
        [one.name for one in old.metadata] == [one.name for one in new.metadata],
        [one.name for one in old.attachments] == [one.name for one in new.attachments],
        [chunk.message_index_offsets.keys() for chunk in old.chunks]
        == [chunk.message_index_offsets.keys() for chunk in new.chunks],
    )
    if not all(same):
        raise ValueError("its summary differs")


def _compare_records(old: Recording, new: Recording) -> None:
    """Compare all records that are no chunks, in their order."""
    pairs = zip(_records(old), _records(new), strict=True)
    for (is_chunk, at, length), (is_new_chunk, new_at, new_length) in pairs:
        if is_chunk != is_new_chunk:
            raise ValueError(f"the record at byte {at} has moved")
        if not is_chunk and old.read(at, length) != new.read(new_at, new_length):
            raise ValueError(f"the record at byte {at} differs")
