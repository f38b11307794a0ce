"""Making an interrupted or damaged recording whole, in place.

What is whole stays where it is, byte for byte: the tail that was cut short is taken off, a damaged
chunk in the middle is hidden from readers by one byte, an event says what is missing, and the
summary is written anew.  Gigabytes of pictures are read once and never copied.
"""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from zlib_ng.zlib_ng import crc32

from station.errors import InputUnusable, RecordingUnreadable
from station.recording.activefile import ACTIVE, lock, sync_folder
from station.recording.appender import McapAppender, Message
from station.recording.chunks import read_chunk, records
from station.recording.events import Event, EventKind
from station.recording.index import FileIndex
from station.recording.layout import DAMAGED
from station.recording.opening import open_file
from station.recording.scan import Scan, decode, scan, without_damaged_tail
from station.recording.topics import Topic, channels_of
from station.recording.verify import VerifyReport, verify

_HIDDEN = 0x80  # opcodes from here up are private: readers pass over them
_PIECE_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class RecoveryReport:
    """What became of a recording."""

    path: Path
    """Where it is now."""
    frames: int
    cut_bytes: int
    """What was taken off its end."""
    damaged_chunks: int
    """Chunks in its middle that fail their checksum and are hidden."""
    verified: VerifyReport

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {
            "path": str(self.path),
            "frames": self.frames,
            "cut_bytes": self.cut_bytes,
            "damaged_chunks": self.damaged_chunks,
            "verified": self.verified.to_json(),
        }


def recover(path: Path, *, now_ns: Callable[[], int] = time.time_ns) -> RecoveryReport:
    """Make a recording whole in place, verify it, and take ``.active`` off its name.

    A recording that is already whole is left as it is.

    Raises
    ------
    InputUnusable
        If there is no such file, or a recording of the final name exists.
    RecordingUnreadable
        If nothing in it can be used.
    StateConflict
        If a process is writing it.
    """
    final = path.with_name(path.name.removesuffix(ACTIVE))
    if final != path and final.exists():
        raise InputUnusable(f"{final} exists; move it away, then recover {path.name} again")
    descriptor = open_file(path, os.O_RDWR)
    try:
        lock(descriptor, path)
        report, cut, damaged = _sound(path), 0, 0
        if report is None:
            cut, damaged = _repair(path, descriptor, now_ns)
            report = verify(path)
        path.rename(final)
        sync_folder(final.parent)
    finally:
        os.close(descriptor)
    return RecoveryReport(final, report.frames, cut, damaged, report)


def _sound(path: Path) -> VerifyReport | None:
    try:
        report = verify(path)
    except RecordingUnreadable:
        return None
    return report if report.ok else None


def _repair(path: Path, descriptor: int, now_ns: Callable[[], int]) -> tuple[int, int]:
    """Return the bytes cut off and the chunks hidden."""
    size = os.fstat(descriptor).st_size
    found = without_damaged_tail(descriptor, scan(descriptor))
    damaged = _hide_damaged_chunks(descriptor, found.index)
    if not found.index.channels:
        raise RecordingUnreadable(
            f"{path}: none of its {size} bytes can be used; the recording never began or another "
            "program wrote it"
        )
    os.ftruncate(descriptor, found.end)
    found.index.data_crc = _crc_of_file(descriptor)
    cut = 0 if found.finished else size - found.end
    appender = McapAppender(descriptor, found.index, found.end)
    appender.finish(_last_words(found, cut, damaged, now_ns()))
    os.fsync(descriptor)
    return cut, damaged


def _hide_damaged_chunks(descriptor: int, index: FileIndex) -> int:
    """Give damaged chunks a private opcode, and learn of the channels inside the others."""
    sound, hidden = [], 0
    for chunk in index.chunks:
        try:
            for opcode, at, body in records(read_chunk(descriptor, chunk.index)):
                if opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                    index.add(decode(opcode, bytes(body)), at, len(body))
            sound.append(chunk)
        except DAMAGED:
            offsets = chunk.index.message_index_offsets.values()
            for offset in (chunk.index.chunk_start_offset, *offsets):
                opcode = os.pread(descriptor, 1, offset)[0]
                os.pwrite(descriptor, bytes([opcode | _HIDDEN]), offset)
            hidden += 1
    index.chunks[:] = sound
    return hidden


def _last_words(found: Scan, cut: int, damaged: int, now_ns: int) -> list[Message]:
    """Return an event for every sensor; its time is the recording's, not today's."""
    last = max((c.index.message_end_time for c in found.index.chunks), default=now_ns)
    date = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(now_ns // 1_000_000_000))
    detail = f"found unfinished, made whole {date}: {cut} bytes cut off, {damaged} chunks damaged"
    body = Event(EventKind.RECOVERED, last, detail).message()
    channels = channels_of(found.index.channels.values(), Topic.EVENTS)
    return [Message(channel, 0, last, last, (body,)) for channel in channels]


def _crc_of_file(descriptor: int) -> int:
    crc, at = 0, 0
    while piece := os.pread(descriptor, _PIECE_BYTES, at):
        crc, at = crc32(piece, crc), at + len(piece)
    return crc
