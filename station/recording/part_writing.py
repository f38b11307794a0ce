"""How each file of a recording begins, and what it says of those before and behind it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from station.errors import InputUnusable, RecordingError
from station.recording.activefile import active_path
from station.recording.camera_numbers import CameraNumbers
from station.recording.events import Event, EventKind
from station.recording.parts import (
    ACCOUNTING,
    CONTINUED_FROM,
    CONTINUED_IN,
    PART,
    SESSION,
    part_path,
)
from station.recording.writer import RecordingSummary, RecordingWriter

_RECORDED_IN_PART = "recorded_in_part"
JOINING = frozenset({EventKind.CONTINUED_FROM, EventKind.CONTINUED_IN})
"""Events that files tell each other; whoever records has told none of them."""


@dataclass(frozen=True, slots=True)
class PartWriting:
    """What the files of one sensor's recording have in common; numbers of files are from 1.

    Attributes
    ----------
    path
        The first file; the others are named after it.
    sensor
        Whose frames and events are written.
    metadata, attachments, reserve_bytes
        As of a `RecordingWriter`; every file has them.
    camera
        Gives the camera model in force, which every file has; asked when a file begins.
    now_ns
        This host's clock, UTC in ns.
    """

    path: Path
    sensor: str
    metadata: Mapping[str, Mapping[str, str]]
    attachments: Mapping[str, bytes]
    camera: Callable[[], CameraNumbers] | None
    reserve_bytes: int
    now_ns: Callable[[], int]

    def part(self, number: int) -> Path:
        """Return where the file of that number is."""
        return part_path(self.path, number)

    def begun(self, number: int) -> RecordingWriter:
        """Begin a file; where that fails nothing of it is left.

        Raises
        ------
        InputUnusable
            If it exists, or its folder does not take it.
        RecordingError
            If it cannot be written.
        """
        writer = self._writer(number, resume=False)
        try:
            self._say_hello(writer, number)
        except RecordingError:
            writer.remove()
            raise
        return writer

    def taken_over(self, number: int) -> RecordingWriter:
        """Go on with the unfinished file of a writer that died."""
        writer = self._writer(number, resume=True)
        if number > 1 and not writer.events_written(self.sensor):
            self._say_hello(writer, number)  # its writer died before it had
        return writer

    def closed_left_behind(self, number: int) -> RecordingSummary:
        """Finish a file that was being closed; what it says of the next one it may lack."""
        writer = RecordingWriter(self.part(number), resume=True, now_ns=self.now_ns)
        if ACCOUNTING not in writer.metadata_names:
            self.say_goodbye(writer, number)
        return writer.finish()

    def say_goodbye(self, writer: RecordingWriter, number: int) -> None:
        """Say in a file which one it goes on in.

        Raises
        ------
        RecordingError
            If there is no space to say it; the next file says it too.
        """
        following = self.part(number + 1).name
        writer.write_event(self.sensor, Event(EventKind.CONTINUED_IN, self.now_ns(), following))
        account = {**self._place_in(writer, number), CONTINUED_IN: following}
        writer.write_metadata(ACCOUNTING, account)

    def place(self, writer: RecordingWriter, number: int) -> dict[str, str]:
        """Return what the last file says of its place; nothing where it is the only one."""
        return {} if number == 1 else self._place_in(writer, number)

    def refuse_leftovers(self, number: int) -> None:
        """Refuse to begin where a file would pass for the part of that number.

        Raises
        ------
        InputUnusable
            If there is one.
        """
        following = self.part(number)
        for left in (following, active_path(following)):
            if left.exists():
                raise InputUnusable(
                    f"{left} exists: it would pass for part {number} of {self.path.name}; move it "
                    "away or choose a new name"
                )

    def _writer(self, number: int, *, resume: bool) -> RecordingWriter:
        return RecordingWriter(
            self.part(number),
            metadata=self._metadata_of(number),
            attachments=self.attachments,
            reserve_bytes=self.reserve_bytes,
            resume=resume,
            now_ns=self.now_ns,
        )

    def _say_hello(self, writer: RecordingWriter, number: int) -> None:
        """Write what a file begins with: where it comes from, and the camera in force."""
        if number > 1:
            before = self.part(number - 1).name
            event = Event(EventKind.CONTINUED_FROM, self.now_ns(), before)
            writer.write_event(self.sensor, event)
        if self.camera is not None:
            writer.write_calibration(self.sensor, self.camera())

    def _metadata_of(self, number: int) -> dict[str, Mapping[str, str]]:
        if number == 1:
            return dict(self.metadata)
        before = self.part(number - 1).name
        session = {**self.metadata.get(SESSION, {}), PART: str(number), CONTINUED_FROM: before}
        return {**self.metadata, SESSION: session}

    def _place_in(self, writer: RecordingWriter, number: int) -> dict[str, str]:
        recorded = str(writer.frames_written(self.sensor))
        return {PART: str(number), _RECORDED_IN_PART: recorded}
