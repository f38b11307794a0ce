"""Going on with a recording whose writer died: its files, and what is in them."""

from dataclasses import dataclass
from pathlib import Path

from station.recording.activefile import active_path
from station.recording.info import info
from station.recording.part_writing import JOINING, PartWriting
from station.recording.parts import left_behind
from station.recording.reader import events
from station.recording.writer import RecordingSummary, RecordingWriter


@dataclass(frozen=True, slots=True)
class TakenOver:
    """A recording taken over.

    Attributes
    ----------
    writer, number
        Of the file to go on with.
    finished
        The files before it.
    entries
        Frames and events that the writer that died had been told to write.
    """

    writer: RecordingWriter
    number: int
    finished: list[RecordingSummary]
    entries: int


def take_over(files: PartWriting, *, files_before: int) -> TakenOver:
    """Close all files that a writer left but the last one, and take up that.

    Entries of the first `files_before` files, which somebody else wrote, do not count.

    Raises
    ------
    RecordingError
        If a file cannot be closed, or written on.
    RecordingUnreadable
        If a finished file cannot be read.
    """
    *earlier, (number, _) = left_behind(files.path) or [(1, files.path)]
    finished, entries = [], 0
    for place, part in earlier:
        if active_path(part).exists():
            finished.append(files.closed_left_behind(place))
        else:
            finished.append(summary_of(part))
        if place > files_before:
            entries += _entries_in(part, files.sensor)
    writer = files.taken_over(number)
    return TakenOver(writer, number, finished, entries + _entries_of(writer, files.sensor))


def summary_of(part: Path) -> RecordingSummary:
    """Return what a finished file holds, as its writer would have said.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is no whole recording.
    """
    found = info(part)
    return RecordingSummary(
        path=part,
        frames={one.sensor: one.frames for one in found.sensors},
        events=sum(one.events for one in found.sensors),
        size_bytes=found.size_bytes,
        disk_full=False,
    )


def _entries_in(part: Path, sensor: str) -> int:
    """Return how many frames and events a finished file holds that its writer was told."""
    frames = sum(one.frames for one in info(part).sensors if one.sensor == sensor)
    told = [event for event in events(part, sensor) if event.kind not in JOINING]
    return frames + len(told)


def _entries_of(writer: RecordingWriter, sensor: str) -> int:
    told = [event for event in writer.events_of(sensor) if event.kind not in JOINING]
    return writer.frames_written(sensor) + len(told)
