"""The frames of sources in batches, each read by the process that works on it.

A picture of 2 MB read where it is needed costs 0.7 ms; handed over it would cost that much more.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from station.pictures import read_picture
from station.pipeline.frames import Frame, files_by_source, is_recording
from station.pipeline.naming import distinct_names
from station.recording import FrameBlock, frame_blocks

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
        for recorded in self.block.frames():
            yield Frame(
                name=f"{self.source}#{recorded.frame_id}",
                source=self.source,
                number=recorded.frame_id,
                picture=recorded.picture,
                sensor=recorded.sensor,
                time_ns=recorded.camera_time_ns,
            )


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


def batches_of(sources: Sequence[Path]) -> Iterator[Batch]:
    """Yield the batches of all sources, in order.

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
            yield from recorded_batches(group, group[0].name)
        else:
            yield from (PictureBatch(path, place) for place, path in enumerate(group))


def recorded_batches(parts: Sequence[Path], source: str) -> Iterator[RecordedBatch]:
    """Yield the batches of one recording, all its files, under one name.

    Raises
    ------
    InputUnusable
        If a file is not there.
    RecordingUnreadable
        If a file is not whole.
    """
    for part in parts:
        for block in frame_blocks(part, chunks_each=_FRAMES_EACH):
            yield RecordedBatch(source, block)
