"""The frames of sources in batches, each read by the process that works on it.

A picture of 2 MB read where it is needed costs 0.7 ms; handed over it would cost that much more.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from station.pictures import read_picture
from station.pipeline.frames import Frame, files_by_source, is_recording
from station.pipeline.naming import distinct_names
from station.recording import (
    BEGINNING,
    FilePlace,
    FrameBlock,
    RecordedFrame,
    frame_blocks,
    parts_from,
)

_FRAMES_EACH = 8
"""Few enough that all cores have some of a short recording."""


class Batch(Protocol):
    """Some frames of one source that follow one another."""

    @property
    def source(self) -> str:
        """What readings call the source."""

    def frames(self) -> Iterator[Frame]:
        """Read the frames, one in memory at a time; raises what `read_frames` raises."""


@dataclass(frozen=True, slots=True)
class RecordedBatch:
    """Frames of a recording."""

    source: str
    block: FrameBlock

    def frames(self) -> Iterator[Frame]:
        return map(partial(_frame, self.source), self.block.frames())


@dataclass(frozen=True, slots=True)
class ReadBatch:
    """Frames of a recording that have been read already."""

    source: str
    recorded: tuple[RecordedFrame, ...]

    def frames(self) -> Iterator[Frame]:
        return map(partial(_frame, self.source), self.recorded)


@dataclass(frozen=True, slots=True)
class PictureBatch:
    """One picture of a folder, or given by itself."""

    path: Path
    place: int
    """Among the pictures of its folder."""

    @property
    def source(self) -> str:
        return self.path.name

    def frames(self) -> Iterator[Frame]:
        picture = read_picture(self.path)
        yield Frame(str(self.path), source=self.source, number=self.place, picture=picture)


def _frame(source: str, recorded: RecordedFrame) -> Frame:
    return Frame(
        name=f"{source}#{recorded.frame_id}",
        source=source,
        number=recorded.frame_id,
        picture=recorded.picture,
        sensor=recorded.sensor,
        time_ns=recorded.camera_time_ns,
    )


def batches_of(sources: Sequence[Path], since: FilePlace = BEGINNING) -> Iterator[Batch]:
    """Yield the batches of all sources, in order; of recordings from a place on.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or is given twice.
    RecordingUnreadable
        If a recording is not whole.
    """
    groups = files_by_source(sources)
    distinct_names([path for group in groups for path in group])
    for group in groups:
        if group and is_recording(group[0]):
            yield from recorded_batches(group, group[0].name, since)
        else:
            yield from (PictureBatch(path, place) for place, path in enumerate(group))


def recorded_batches(
    parts: Sequence[Path], source: str, since: FilePlace = BEGINNING
) -> Iterator[RecordedBatch]:
    """Yield the batches of one recording, all its files from a place on, under one name.

    Raises
    ------
    InputUnusable
        If a file is not there.
    RecordingUnreadable
        If a file is not whole.
    """
    for part, from_byte in parts_from(parts, since):
        for block in frame_blocks(part, chunks_each=_FRAMES_EACH, from_byte=from_byte):
            yield RecordedBatch(source, block)
