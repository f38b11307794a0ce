"""A recording in blocks of frames, which other processes read."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from station.recording.opening import Recording, open_file, open_recording
from station.recording.reader import RecordedFrame, frames_in
from station.recording.soundness import ensure_sound_around_chunks

_CLOSED = -1


@dataclass(frozen=True, slots=True)
class FrameBlock:
    """Frames of a recording that follow one another; it can be handed to another process."""

    recording: Recording
    """Closed; of its chunks only those of the block."""

    def frames(self) -> Iterator[RecordedFrame]:
        """Yield the frames, one in memory at a time, each chunk held against its checksum.

        Raises
        ------
        InputUnusable
            If the file has gone meanwhile.
        RecordingUnreadable
            Where it is damaged, when that is reached.
        """
        descriptor = open_file(self.recording.path)
        try:
            yield from frames_in(replace(self.recording, descriptor=descriptor))
        finally:
            os.close(descriptor)


def frame_blocks(path: Path, *, chunks_each: int, from_byte: int = 0) -> list[FrameBlock]:
    """Return the blocks of a recording, in order; a chunk holds one large picture or many small.

    Chunks that begin before `from_byte` are left out.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is not a whole recording, or damaged outside its chunks.
    """
    with open_recording(path) as recording:
        ensure_sound_around_chunks(recording)
        closed = replace(recording, descriptor=_CLOSED)
    chunks = [each for each in recording.chunks if each.chunk_start_offset >= from_byte]
    return [
        FrameBlock(replace(closed, chunks=tuple(chunks[first : first + chunks_each])))
        for first in range(0, len(chunks), chunks_each)
    ]
