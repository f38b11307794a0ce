"""Proving a recording: every byte against its checksum, every frame decoded, every id explained."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from zlib_ng.zlib_ng import crc32

from station.progress import Progress, silent
from station.recording.chunks import StoredMessage, messages, read_chunk
from station.recording.events import Event, EventKind
from station.recording.frame_ids import id_after, ids_skipped
from station.recording.layout import DAMAGED, PREFIX
from station.recording.opening import Recording, open_recording
from station.recording.rawimage import read_raw_image
from station.recording.topics import Topic, parse_topic

_PIECE_BYTES = 1 << 20
_EXPLAINING = frozenset({
    EventKind.FRAMES_LOST,
    EventKind.FRAME_REFUSED,
    EventKind.FRAMES_DROPPED,
    EventKind.RECOVERED,
})


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """What a full reading of a recording found."""

    path: Path
    frames: int
    """Frames that decode."""
    events: int
    lost: int
    """Frames that are missing and said to be, in the recording's own events."""
    problems: tuple[str, ...]
    """What is wrong; none in a sound recording."""

    @property
    def ok(self) -> bool:
        """Nothing is wrong with the file; frames may still be missing from it, see `lost`."""
        return not self.problems

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {
            "path": str(self.path),
            "ok": self.ok,
            "frames": self.frames,
            "events": self.events,
            "lost": self.lost,
            "problems": list(self.problems),
        }


def verify(path: Path, progress: Progress = silent) -> VerifyReport:
    """Read a whole recording and report what is wrong with it.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is not a recording, is cut short or unfinished, or its summary is damaged.
    """
    with open_recording(path) as recording:
        problems = _data_section(recording, progress)
        contents = _Contents()
        for chunk in recording.chunks:
            try:
                for message in messages(read_chunk(recording.descriptor, chunk)):
                    contents.take(recording, message)
            except DAMAGED as error:
                problems.append(f"chunk at byte {chunk.chunk_start_offset}: {error}")
            progress(chunk.chunk_start_offset / recording.size_bytes, "frames")
        problems += contents.problems
        problems += _miscounts(recording, contents.counts)
        problems += contents.unexplained()
        return VerifyReport(
            path=path,
            frames=sum(len(ids) for ids in contents.frame_ids.values()),
            events=sum(len(found) for found in contents.events.values()),
            lost=contents.lost(),
            problems=tuple(problems),
        )


class _Contents:
    """Counts, frame ids and events, gathered message by message."""

    def __init__(self) -> None:
        self.counts: Counter[int] = Counter()
        self.frame_ids: dict[str, list[tuple[int, int]]] = {}
        """(frame id, receive time) per sensor."""
        self.events: dict[str, list[Event]] = {}
        self.problems: list[str] = []

    def take(self, recording: Recording, message: StoredMessage) -> None:
        self.counts[message.channel] += 1
        channel = recording.channels.get(message.channel)
        topic = parse_topic(channel.topic) if channel else None
        if topic is None:
            return
        sensor, kind = topic
        try:
            if kind is Topic.IMAGE:
                _check_image(message.data)
                place = message.sequence, message.log_time_ns
                self.frame_ids.setdefault(sensor, []).append(place)
            elif kind is Topic.EVENTS:
                event = Event.from_message(message.data, message.log_time_ns)
                self.events.setdefault(sensor, []).append(event)
        except DAMAGED as error:
            self.problems.append(f"{sensor} {kind} {message.sequence}: {error}")

    def lost(self) -> int:
        """Return how many frames the events say are missing."""
        counted = _EXPLAINING | {EventKind.FRAMES_MISCOUNTED}
        return sum(e.count for found in self.events.values() for e in found if e.kind in counted)

    def unexplained(self) -> list[str]:
        """Return a line for every gap in the frame ids that no event explains."""
        problems = []
        for sensor, frames in self.frame_ids.items():
            explained = _explained_ids(self.events.get(sensor, []))
            restarts = [
                e.time_ns for e in self.events.get(sensor, []) if e.kind is EventKind.CAMERA_BACK
            ]
            for (before, since), (frame_id, until) in zip(frames, frames[1:], strict=False):
                if any(since <= time <= until for time in restarts):
                    continue
                skipped = ids_skipped(before, frame_id)
                if skipped is None:
                    problems.append(f"{sensor}: frame {frame_id} follows frame {before}")
                elif not all(id_after(before, n) in explained for n in range(1, skipped + 1)):
                    problems.append(
                        f"{sensor}: no event says what became of the {skipped} frames between "
                        f"{before} and {frame_id}"
                    )
        return problems


def _explained_ids(events: list[Event]) -> set[int]:
    return {
        id_after(event.frame_id, n)
        for event in events
        if event.kind in _EXPLAINING and event.frame_id is not None
        for n in range(event.count)
    }


def _check_image(data: memoryview) -> None:
    image = read_raw_image(data)
    if not (image.width > 0 and len(image.data) == image.height * image.step):
        raise ValueError(
            f"{len(image.data)} bytes are no picture of {image.width} x {image.height} pixels"
        )


def _data_section(recording: Recording, progress: Progress) -> list[str]:
    """Compare the checksum of all that stands before the summary."""
    end_record = recording.read(recording.data_end - PREFIX.size - 4, PREFIX.size + 4)
    if PREFIX.unpack_from(end_record) != (Opcode.DATA_END, 4):
        return ["no end record behind the data"]
    expected = int.from_bytes(end_record[-4:], "little")
    if expected == 0:
        return []  # of another writer, which did not compute it
    crc, at, end = 0, 0, recording.data_end - len(end_record)
    while at < end:
        piece = recording.read(at, min(_PIECE_BYTES, end - at))
        crc, at = crc32(piece, crc), at + len(piece)
        progress(at / recording.size_bytes, "checksum")
    return [] if crc == expected else ["the checksum of the data section does not match"]


def _miscounts(recording: Recording, counts: Counter[int]) -> list[str]:
    expected = recording.statistics.channel_message_counts
    return [
        f"{channel.topic}: {counts[channel.id]} messages, the summary says "
        f"{expected.get(channel.id, 0)}"
        for channel in recording.channels.values()
        if counts[channel.id] != expected.get(channel.id, 0)
    ]
