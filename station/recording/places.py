"""A place in a recording, between two of its frames: where reading may go on."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from station.errors import InputUnusable
from station.recording.layout import MAGIC
from station.recording.opening import open_recording
from station.recording.parts import parts_of
from station.recording.topics import Topic, channels_of


@dataclass(frozen=True, slots=True)
class FilePlace:
    """Before one of the frames of a recording, or behind the last one.

    Raises
    ------
    ValueError
        If the part is not from 1 up, or a number is negative.
    """

    part: int = 1
    """The file, from 1."""
    offset_bytes: int = len(MAGIC)
    """Where in it the chunk of the frame begins; or a byte behind the beginning of the last one."""
    frames: int = 0
    """Frames of the recording before the place, in all its files."""

    def __post_init__(self) -> None:
        if not (self.part >= 1 and self.offset_bytes >= 0 and self.frames >= 0):
            raise ValueError(f"no place in a recording: {self}")


BEGINNING = FilePlace()


def has_place(path: Path, place: FilePlace) -> bool:
    """Tell whether a finished recording has as many frames before a place as the place says.

    It has not where what a crash left was cut or mended before it.

    Raises
    ------
    InputUnusable, RecordingUnreadable
        If the recording cannot be read.
    """
    parts = parts_of(path)
    if place.part > len(parts):
        return False
    before = sum(len(_offsets(part)) for part in parts[: place.part - 1])
    own = [offset for offset in _offsets(parts[place.part - 1]) if offset < place.offset_bytes]
    return before + len(own) == place.frames


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


def _offsets(part: Path) -> list[int]:
    """Return where the chunks of a file begin that hold a frame; our writer puts one into each."""
    with open_recording(part) as recording:
        channels = channels_of(recording.channels.values(), Topic.IMAGE).keys()
        return [
            chunk.chunk_start_offset
            for chunk in recording.chunks
            if not channels.isdisjoint(chunk.message_index_offsets)
        ]
