"""Reading a recording while it is being written: what is whole is there, the rest is not yet.

The writer is never disturbed: the files are opened for reading, without its lock. A file keeps its
descriptor when it is renamed, and says by its end record that nothing follows in it.
"""

import os
from pathlib import Path

from station.errors import RecordingUnreadable
from station.recording.activefile import active_path
from station.recording.index import IndexedChunk
from station.recording.layout import MAGIC
from station.recording.opening import Recording
from station.recording.parts import part_path
from station.recording.places import BEGINNING, FilePlace
from station.recording.reader import RecordedFrame, frames_in
from station.recording.scan import Scan, scan, without_unindexed_tail
from station.recording.topics import Topic, channels_of


class GrowingRecording:
    """The frames of one sensor's recording, as its files grow.

    Parameters
    ----------
    path
        What the first file is, or will be, called.
    since
        Where to begin; the frame there is the first one read.
    """

    def __init__(self, path: Path, since: FilePlace = BEGINNING) -> None:
        self._path = path
        self._next = since
        self._file: _GrowingFile | None = None

    def read(self, most: int) -> list[tuple[FilePlace, RecordedFrame]]:
        """Return the next frames, with the place of each; none where none is whole yet.

        Raises
        ------
        RecordingUnreadable
            If a frame fails its checksum, or the writer took back what had been there.
        """
        if self._file is None:
            self._file = _opened(self._path, self._next.part)
        found: list[tuple[FilePlace, RecordedFrame]] = []
        while self._file is not None and len(found) < most:
            for offset, frame in self._file.read(most - len(found), self._next.offset_bytes):
                place = FilePlace(self._next.part, offset, self._next.frames)
                found.append((place, frame))
                self._next = FilePlace(place.part, offset + 1, place.frames + 1)
            if not (self._file.exhausted and self._open_next()):
                break
        return found

    def read_newest(self) -> tuple[FilePlace, RecordedFrame] | None:
        """Return the last frame that is whole, with its place; those before are passed over.

        None where no frame has become whole since the last time.  `read` says what it raises.
        """
        if self._file is None:
            self._file = _opened(self._path, self._next.part)
        newest = None
        while self._file is not None:
            passed, found = self._file.read_newest(self._next.offset_bytes)
            for offset, frame in found:
                place = FilePlace(self._next.part, offset, self._next.frames + passed - 1)
                newest = (place, frame)
                self._next = FilePlace(place.part, offset + 1, place.frames + 1)
            if not (self._file.exhausted and self._open_next()):
                break
        return newest

    @property
    def end(self) -> FilePlace | None:
        """The place behind the last frame; None where `read` has not found all of it ended."""
        if self._file is None or not self._file.exhausted or self._open_next():
            return None
        return self._next

    def close(self) -> None:
        """Close the file that is open; safe to call twice."""
        if self._file is not None:
            self._file.close()
        self._file = None

    def _open_next(self) -> bool:
        """Go on in the next part, where the recording goes on in one."""
        following = _opened(self._path, self._next.part + 1)
        if following is None:
            return False
        self.close()
        self._file = following
        self._next = FilePlace(self._next.part + 1, 0, self._next.frames)
        return True


class _GrowingFile:
    """One file, and how far it has been walked."""

    def __init__(self, path: Path, descriptor: int) -> None:
        self._path, self._descriptor = path, descriptor
        self._scan: Scan | None = None
        self._taken = 0

    def close(self) -> None:
        os.close(self._descriptor)

    @property
    def exhausted(self) -> bool:
        """Whether its writer has ended it and all of it has been taken."""
        found = self._scan
        return found is not None and found.finished and self._taken == len(found.index.chunks)

    def read(self, most: int, from_byte: int) -> list[tuple[int, RecordedFrame]]:
        """Return (offset, frame) of the next whole chunks with a frame, from a byte on."""
        return self._frames_of(self._take(most, from_byte))

    def read_newest(self, from_byte: int) -> tuple[int, list[tuple[int, RecordedFrame]]]:
        """Return how many frames have become whole from a byte on, and the last of them."""
        passed = self._take(None, from_byte)
        return len(passed), self._frames_of(passed[-1:])

    def _take(self, most: int | None, from_byte: int) -> list[IndexedChunk]:
        """Return the next whole chunks with a frame; all of them where `most` is None."""
        found = self._walked()
        if found is None:
            return []
        channels = channels_of(found.index.channels.values(), Topic.IMAGE).keys()
        wanted: list[IndexedChunk] = []
        while self._taken < len(found.index.chunks) and (most is None or len(wanted) < most):
            chunk = found.index.chunks[self._taken]
            self._taken += 1
            if chunk.index.chunk_start_offset >= from_byte and channels & chunk.counts.keys():
                self._ensure_one_frame(chunk)
                wanted.append(chunk)
        return wanted

    def _frames_of(self, chunks: list[IndexedChunk]) -> list[tuple[int, RecordedFrame]]:
        if self._scan is None or not chunks:
            return []
        offsets = [chunk.index.chunk_start_offset for chunk in chunks]
        return list(zip(offsets, frames_in(self._recording(self._scan, chunks)), strict=True))

    def _walked(self) -> Scan | None:
        """Return what is whole of the file by now; None where it has not begun."""
        size = os.fstat(self._descriptor).st_size
        if self._scan is not None and size < self._scan.end:
            raise RecordingUnreadable(
                f"{self._path}: cut from {self._scan.end} to {size} bytes while it was followed; "
                "measure it once it is finished"
            )
        if size > len(MAGIC):
            self._scan = without_unindexed_tail(scan(self._descriptor, self._scan))
        return self._scan

    def _ensure_one_frame(self, chunk: IndexedChunk) -> None:
        if sum(chunk.counts.values()) != 1:
            raise RecordingUnreadable(
                f"{self._path}: several messages in the chunk at byte "
                f"{chunk.index.chunk_start_offset}; only a recording of one frame a chunk, as the "
                "station writes it, can be followed"
            )

    def _recording(self, found: Scan, chunks: list[IndexedChunk]) -> Recording:
        """Return some chunks of the file as a finished recording of these would be."""
        return Recording(
            path=self._path,
            descriptor=self._descriptor,
            size_bytes=found.end,
            data_end=found.end,
            schemas=found.index.schemas,
            channels=found.index.channels,
            chunks=tuple(chunk.index for chunk in chunks),
            attachments=(),
            metadata=(),
            statistics=found.index.statistics(),
        )


def _opened(path: Path, number: int) -> _GrowingFile | None:
    """Open a part of a recording by the name it has now; None where there is none yet."""
    part = part_path(path, number)
    # In this order: the writer renames the first to the second, never back.
    for name in (active_path(part), part):
        try:
            return _GrowingFile(part, os.open(name, os.O_RDONLY))
        except FileNotFoundError:
            continue
    return None
