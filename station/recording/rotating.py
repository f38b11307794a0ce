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

from station.errors import RecordingError, StationError
from station.recording.camera_numbers import CameraNumbers
from station.recording.events import Event
from station.recording.part_writing import PartWriting
from station.recording.parts import ACCOUNTING
from station.recording.rotation import Rotation
from station.recording.taking_over import summary_of, take_over
from station.recording.writer import RecordingWriter

_RETRY_S = 10.0
"""After a next file could not be begun."""


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
    RecordingError
        If the file cannot be written.
    RecordingUnreadable
        If a file that it goes on behind is no whole recording.
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
        self._files = PartWriting(
            path=path,
            sensor=sensor,
            metadata=dict(metadata or {}),
            attachments=dict(attachments or {}),
            camera=camera,
            reserve_bytes=reserve_bytes,
            now_ns=now_ns,
        )
        self._sensor, self._rotation, self._clock_s = sensor, rotation, clock_s
        self._failure: StationError | None = None
        self._closing: threading.Thread | None = None
        self._first_frame_s: float | None = None
        self._not_before_s = 0.0
        self.entries_found = 0
        """Frames and events that the writer that died had been told to write."""
        if resume:
            self._take_over(files_before)
        else:
            self._begin(files_before)

    def _begin(self, files_before: int) -> None:
        self._number = files_before + 1
        self._files.refuse_leftovers(self._number + 1)
        earlier = (self._files.part(number) for number in range(1, self._number))
        self._finished = [summary_of(part) for part in earlier]
        self._writer = self._files.begun(self._number)

    def _take_over(self, files_before: int) -> None:
        found = take_over(self._files, files_before=files_before)
        self._writer, self._number, self._finished = found.writer, found.number, found.finished
        self._first_frame_s = self._clock_s()
        self.entries_found = found.entries

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
            place = self._files.place(self._writer, self._number)
            self._writer.write_metadata(ACCOUNTING, {**accounting, **place})
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
            self._writer = self._files.begun(self._number + 1)
        except StationError:
            # The present file takes the frames.  A disk that is full will show there by itself.
            self._not_before_s = self._clock_s() + _RETRY_S
            return
        # Without space to say where it goes on it has been ended whole; the next file says it too.
        with contextlib.suppress(RecordingError):
            self._files.say_goodbye(present, self._number)
        self._number, self._first_frame_s = self._number + 1, None
        self._closing = threading.Thread(target=self._close, args=(present,), name="close part")
        self._closing.start()

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
