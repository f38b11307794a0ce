"""A recording that goes on in a next file before one grows long.

Readers load a file's whole index and a damaged file costs all that is in it, so long recordings are
kept in parts.  The next file is open before the last one is closed, and that one is put on the disk
beside the writing: no frame waits for it, and where no next file can be begun the present one goes
on.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from station.errors import InputUnusable, RecordingError, StationError
from station.recording.activefile import active_path
from station.recording.camera_numbers import CameraNumbers
from station.recording.events import Event, EventKind
from station.recording.info import info
from station.recording.parts import (
    ACCOUNTING,
    CONTINUED_FROM,
    CONTINUED_IN,
    PART,
    SESSION,
    left_behind,
    part_path,
)
from station.recording.reader import events
from station.recording.writer import RecordingSummary, RecordingWriter

_RETRY_S = 10.0
"""After a next file could not be begun."""
_JOINING = frozenset({EventKind.CONTINUED_FROM, EventKind.CONTINUED_IN})


@dataclass(frozen=True, slots=True)
class Rotation:
    """When a recording goes on in a next file; it stays in one where neither is given."""

    seconds: float | None = None
    """After so long since the file's first frame."""
    size_bytes: int | None = None
    """After so many bytes."""

    def __post_init__(self) -> None:
        if not (self.seconds is None or self.seconds > 0.0):
            raise ValueError(f"seconds must be more than 0, got {self.seconds}")
        if not (self.size_bytes is None or self.size_bytes > 0):
            raise ValueError(f"size_bytes must be more than 0, got {self.size_bytes}")

    def due(self, seconds: float, size_bytes: int) -> bool:
        """Whether a file of that age and size is followed by another."""
        old = self.seconds is not None and seconds >= self.seconds
        return old or (self.size_bytes is not None and size_bytes >= self.size_bytes)


@dataclass(frozen=True, slots=True)
class PartsSummary:
    """What the files of a finished recording hold together."""

    paths: tuple[Path, ...]
    frames: int
    disk_full: bool
    """The recording ended early, for lack of space."""


class RotatingWriter:
    """One sensor's recording, in as many files as `rotation` asks for.

    Parameters
    ----------
    path
        The first file; the others are named after it.
    sensor
        Whose frames and events are written.
    rotation
        When to go on in a next file.
    metadata, attachments, reserve_bytes
        As of a `RecordingWriter`; every file has them.
    camera
        Gives the camera model in force, which every file has; asked when a file begins.
    resume
        Go on with the unfinished files of a writer that died.
    files_before
        Finished files of the recording that it goes on behind, written by somebody else.
    now_ns, clock_s
        This host's clock, UTC in ns; and one that only runs forward, s.

    Raises
    ------
    InputUnusable
        If a file of the name to begin with, or of a next part of it, exists.
    """

    def __init__(
        self,
        path: Path,
        sensor: str,
        *,
        rotation: Rotation,
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        attachments: Mapping[str, bytes] | None = None,
        camera: Callable[[], CameraNumbers] | None = None,
        reserve_bytes: int = 0,
        resume: bool = False,
        files_before: int = 0,
        now_ns: Callable[[], int] = time.time_ns,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._path, self._sensor, self._rotation = path, sensor, rotation
        self._metadata, self._attachments = dict(metadata or {}), dict(attachments or {})
        self._now_ns, self._clock_s = now_ns, clock_s
        self._camera, self._reserve_bytes = camera, reserve_bytes
        self._finished: list[RecordingSummary] = []
        self._failure: StationError | None = None
        self._closing: threading.Thread | None = None
        self._first_frame_s: float | None = None
        self._not_before_s = 0.0
        self._files_before, self._number = files_before, files_before + 1
        self.entries_found = 0
        """Frames and events that the writer that died had been told to write."""
        if resume:
            self._writer = self._take_over()
        else:
            _refuse_leftovers(path, self._number + 1)
            earlier = (part_path(path, number) for number in range(1, self._number))
            self._finished = [_summary_of(part) for part in earlier]
            self._writer = self._begun(self._number)

    def write_frame(
        self,
        frame_id: int,
        camera_time_ns: int,
        host_time_ns: int,
        picture: memoryview,
        width: int,
        height: int,
    ) -> None:
        """Append a mono8 picture, in a next file where that is due."""
        self._go_on_if_due()
        if self._first_frame_s is None:
            self._first_frame_s = self._clock_s()
        self._writer.write_frame(
            self._sensor, frame_id, camera_time_ns, host_time_ns, picture, width, height
        )

    def write_event(self, event: Event) -> None:
        """Append an event."""
        self._writer.write_event(self._sensor, event)

    def finish(self, accounting: Mapping[str, str] | None = None) -> PartsSummary:
        """Close the last file, with the account of all frames in it, and see the others closed.

        Raises
        ------
        RecordingError
            If one of the files could not be closed.
        """
        if accounting is not None:
            self._writer.write_metadata(ACCOUNTING, {**accounting, **self._place()})
        self._wait_for_closing()
        self._finished.append(self._writer.finish())
        if self._failure is not None:
            raise self._failure
        return PartsSummary(
            paths=tuple(part.path for part in self._finished),
            frames=sum(part.frames.get(self._sensor, 0) for part in self._finished),
            disk_full=any(part.disk_full for part in self._finished),
        )

    def discard(self) -> None:
        """Take back a recording that has just begun: nothing of it is left."""
        self._writer.discard()

    # -- going on in a next file ----------------------------------------------------------------

    def _go_on_if_due(self) -> None:
        if self._first_frame_s is None or self._still_closing:
            return
        now_s = self._clock_s()
        due = self._rotation.due(now_s - self._first_frame_s, self._writer.size_bytes)
        if due and now_s >= self._not_before_s:
            self._go_on()

    def _go_on(self) -> None:
        """Begin a next file, then close the present one beside the writing."""
        present = self._writer
        try:
            self._writer = self._begun(self._number + 1)
        except StationError:
            # The present file takes the frames.  A disk that is full will show there by itself.
            self._not_before_s = self._clock_s() + _RETRY_S
            return
        # Without space to say where it goes on it has been ended whole; the next file says it too.
        with contextlib.suppress(RecordingError):
            self._say_goodbye(present)
        self._number, self._first_frame_s = self._number + 1, None
        self._closing = threading.Thread(target=self._close, args=(present,), name="close part")
        self._closing.start()

    def _begun(self, number: int) -> RecordingWriter:
        """Begin a part; where that fails nothing of it is left."""
        writer = RecordingWriter(
            part_path(self._path, number),
            metadata=self._metadata_of(number),
            attachments=self._attachments,
            reserve_bytes=self._reserve_bytes,
            now_ns=self._now_ns,
        )
        try:
            self._write_start(writer, number)
        except RecordingError:
            writer.remove()
            raise
        return writer

    def _write_start(self, writer: RecordingWriter, number: int) -> None:
        if number > 1:
            before = part_path(self._path, number - 1).name
            event = Event(EventKind.CONTINUED_FROM, self._now_ns(), before)
            writer.write_event(self._sensor, event)
        if self._camera is not None:
            writer.write_calibration(self._sensor, self._camera())

    def _metadata_of(self, number: int) -> dict[str, Mapping[str, str]]:
        if number == 1:
            return dict(self._metadata)
        before = part_path(self._path, number - 1).name
        session = {**self._metadata.get(SESSION, {}), PART: str(number), CONTINUED_FROM: before}
        return {**self._metadata, SESSION: session}

    def _say_goodbye(self, writer: RecordingWriter) -> None:
        following = part_path(self._path, self._number + 1).name
        event = Event(EventKind.CONTINUED_IN, self._now_ns(), following)
        writer.write_event(self._sensor, event)
        account = {
            PART: str(self._number),
            "recorded_in_part": str(writer.frames_written(self._sensor)),
            CONTINUED_IN: following,
        }
        writer.write_metadata(ACCOUNTING, account)

    def _place(self) -> dict[str, str]:
        """Return what the last of several files says of its place."""
        if self._number == 1:
            return {}
        recorded = str(self._writer.frames_written(self._sensor))
        return {PART: str(self._number), "recorded_in_part": recorded}

    # -- closing files --------------------------------------------------------------------------

    @property
    def _still_closing(self) -> bool:
        return self._closing is not None and self._closing.is_alive()

    def _close(self, writer: RecordingWriter) -> None:
        try:
            self._finished.append(writer.finish())
        except StationError as error:
            self._failure = error

    def _wait_for_closing(self) -> None:
        if self._closing is not None:
            self._closing.join()

    # -- going on after a death -----------------------------------------------------------------

    def _take_over(self) -> RecordingWriter:
        """Close all files but the last one, and go on with that."""
        *earlier, (number, last) = left_behind(self._path) or [(1, self._path)]
        for place, part in earlier:
            if active_path(part).exists():
                self._number = place
                self._close_left_behind(part)
            else:
                self._finished.append(_summary_of(part))
            if place > self._files_before:
                self.entries_found += _entries_in(part, self._sensor)
        self._number = number
        writer = RecordingWriter(
            last,
            metadata=self._metadata_of(number),
            attachments=self._attachments,
            reserve_bytes=self._reserve_bytes,
            resume=True,
            now_ns=self._now_ns,
        )
        self._first_frame_s = self._clock_s()
        told = [e for e in writer.events_of(self._sensor) if e.kind not in _JOINING]
        frames = writer.frames_written(self._sensor)
        self.entries_found += frames + len(told)
        if number > 1 and not writer.events_written(self._sensor):
            self._write_start(writer, number)  # its writer died before it had
        return writer

    def _close_left_behind(self, part: Path) -> None:
        """Finish a file that was being closed; what it says of the next one it may lack."""
        writer = RecordingWriter(part, resume=True, now_ns=self._now_ns)
        if ACCOUNTING not in writer.metadata_names:
            self._say_goodbye(writer)
        self._finished.append(writer.finish())


def _refuse_leftovers(path: Path, number: int) -> None:
    following = part_path(path, number)
    for left in (following, active_path(following)):
        if left.exists():
            raise InputUnusable(
                f"{left} exists: it would pass for part {number} of {path.name}; move it away or "
                "choose a new name"
            )


def _summary_of(part: Path) -> RecordingSummary:
    found = info(part)
    return RecordingSummary(
        path=part,
        frames={one.sensor: one.frames for one in found.sensors},
        events=sum(one.events for one in found.sensors),
        size_bytes=found.size_bytes,
        disk_full=False,
    )


def _entries_in(part: Path, sensor: str) -> int:
    """Return how many frames and events a finished part holds that its writer was told."""
    frames = sum(one.frames for one in info(part).sensors if one.sensor == sensor)
    told = [event for event in events(part, sensor) if event.kind not in _JOINING]
    return frames + len(told)
