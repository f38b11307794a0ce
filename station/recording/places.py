"""A place in a recording, between two of its frames: where reading may go on."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mcap.records import ChunkIndex

from station.errors import InputUnusable
from station.recording.layout import MAGIC
from station.recording.opening import Recording, open_recording
from station.recording.parts import parts_of
from station.recording.topics import Topic, channels_of


@dataclass(frozen=True, slots=True)
class FilePlace:
    """Before one of the frames of a recording.

    Raises
    ------
    ValueError
        If the part is not from 1 up, or a number is negative.
    """

    part: int = 1
    """The file that the frame is in, from 1."""
    offset_bytes: int = len(MAGIC)
    """Where its chunk begins in that file."""
    frames: int = 0
    """Frames of the recording before it, in all its files."""

    def __post_init__(self) -> None:
        if not (self.part >= 1 and self.offset_bytes >= 0 and self.frames >= 0):
            raise ValueError(f"no place in a recording: {self}")


BEGINNING = FilePlace()


def has_place(path: Path, place: FilePlace) -> bool:
    """Tell whether a finished recording has a frame at a place, and as many before it.

    It has not where what a crash left was cut or mended before the place.

    Raises
    ------
    InputUnusable, RecordingUnreadable
        If the recording cannot be read.
    """
    parts = parts_of(path)
    if place == BEGINNING:
        return True
    if place.part > len(parts):
        return False
    before = sum(_count(part) for part in parts[: place.part - 1])
    with open_recording(parts[place.part - 1]) as recording:
        offsets = [chunk.chunk_start_offset for chunk in chunks_with_frames(recording)]
    if place.offset_bytes not in offsets:
        return False
    return before + offsets.index(place.offset_bytes) == place.frames


def chunks_with_frames(recording: Recording) -> Sequence[ChunkIndex]:
    """Return the chunks that hold a frame, in file order."""
    channels = channels_of(recording.channels.values(), Topic.IMAGE).keys()
    return [
        chunk for chunk in recording.chunks if not channels.isdisjoint(chunk.message_index_offsets)
    ]


def parts_from(parts: Sequence[Path], place: FilePlace) -> list[tuple[Path, int]]:
    """Return the files from a place on, and from which byte of each.

    Raises
    ------
    InputUnusable
        If there is no such part.
    """
    if place.part > len(parts):
        raise InputUnusable(f"{parts[0]} has {len(parts)} parts, no part {place.part}")
    first, *later = parts[place.part - 1 :]
    return [(first, place.offset_bytes), *((part, 0) for part in later)]


def _count(part: Path) -> int:
    with open_recording(part) as recording:
        return len(chunks_with_frames(recording))
