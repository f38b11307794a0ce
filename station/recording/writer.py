"""Writing a recording: frames, calibration and events of sensors into one MCAP file."""

import contextlib
import time
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from mcap.records import Attachment, Channel, Metadata, Schema

from station.errors import DiskFull, RecordingError
from station.recording.activefile import ActiveFile, active_path
from station.recording.appender import Buffer, McapAppender, Message
from station.recording.camera_numbers import CameraNumbers
from station.recording.events import Event, EventKind
from station.recording.rawimage import raw_image_around
from station.recording.topics import Topic, channels_of, message_encoding, schema_of, topic_name

LIBRARY = "treadline"
_MEDIA_TYPES = {".json": "application/json", ".csv": "text/csv"}


@dataclass(frozen=True, slots=True)
class RecordingSummary:
    """What a finished recording holds."""

    path: Path
    frames: Mapping[str, int]
    """Frames per sensor."""
    events: int
    size_bytes: int
    disk_full: bool
    """The recording ended early, for lack of space."""


class RecordingWriter:
    """A recording being written; as a context manager it finishes whatever happens.

    Parameters
    ----------
    path
        The recording to be; until it is finished the file is called ``NAME.active``.
    metadata
        Names and values, by the name of their record: ``station``, ``session``, ``camera``.
    attachments
        Files to put in, by name: the calibration in force.
    reserve_bytes
        Space that no frame takes: what else is on the disk, a database, must go on being written.
    resume
        Go on with the unfinished file of a writer that died.
    now_ns
        This host's clock, UTC in ns.

    Raises
    ------
    InputUnusable
        If the recording exists or its folder does not take it.
    StateConflict
        If it is resumed while its writer lives.
    DiskFull
        From any method: the recording has been ended before what did not fit, and is whole.
    """

    def __init__(
        self,
        path: Path,
        *,
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        attachments: Mapping[str, bytes] | None = None,
        reserve_bytes: int = 0,
        resume: bool = False,
        now_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._now_ns = now_ns
        self._reserve_bytes = reserve_bytes
        self._summary: RecordingSummary | None = None
        self._file = ActiveFile.reopen(path) if resume else ActiveFile.create(path)
        self._appender = self._started(resume=resume)
        try:
            self._write_start(metadata or {}, attachments or {})
        except DiskFull:
            if not resume:  # there is nothing in it to keep
                path.unlink()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.finish()

    @property
    def path(self) -> Path:
        """The recording to be."""
        return self._file.path

    def write_frame(
        self,
        sensor: str,
        frame_id: int,
        camera_time_ns: int,
        host_time_ns: int,
        picture: memoryview,
        width: int,
        height: int,
    ) -> None:
        """Append a mono8 picture; `picture` is its bytes, row by row.

        `camera_time_ns` is the exposure's time in UTC, `host_time_ns` when the frame was received.
        """
        if picture.nbytes != width * height:
            raise ValueError(f"{width} x {height} pixels cannot be {picture.nbytes} bytes")
        head, tail = raw_image_around(camera_time_ns, sensor, width, height, picture.nbytes)
        parts = (head, picture.cast("B"), tail)
        self._write(sensor, Topic.IMAGE, frame_id, host_time_ns, camera_time_ns, parts)

    def write_event(self, sensor: str, event: Event) -> None:
        """Append an event."""
        self._write(sensor, Topic.EVENTS, 0, event.time_ns, event.time_ns, (event.message(),))

    def write_calibration(self, sensor: str, camera: CameraNumbers) -> None:
        """Append the camera model in force."""
        now = self._now_ns()
        body = _camera_message(sensor, camera, now)
        self._write(sensor, Topic.CALIBRATION, 0, now, now, (body,))

    def write_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Append a record of names and values."""
        with self._writing():
            self._appender.add(Metadata(name, dict(values)))

    def write_attachment(self, name: str, content: bytes) -> None:
        """Append a file."""
        now = self._now_ns()
        media_type = _MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream")
        with self._writing():
            self._appender.add(Attachment(now, now, name, media_type, content))

    def frames_written(self, sensor: str) -> int:
        """Return how many frames of a sensor the recording holds."""
        return self._appender.index.messages_on(topic_name(sensor, Topic.IMAGE))

    def events_written(self, sensor: str) -> int:
        """Return how many events of a sensor the recording holds."""
        return self._appender.index.messages_on(topic_name(sensor, Topic.EVENTS))

    def events_of(self, sensor: str) -> list[Event]:
        """Return the events of a sensor that the recording holds, read back from it."""
        channel = self._appender.index.channel_of(topic_name(sensor, Topic.EVENTS))
        return [
            Event.from_message(message.data, message.log_time_ns)
            for message in self._appender.messages_on(channel)
        ]

    @property
    def metadata_names(self) -> set[str]:
        """Names of the metadata records written."""
        return self._appender.index.metadata_names

    @property
    def size_bytes(self) -> int:
        """Bytes written so far."""
        return self._appender.size

    def finish(self) -> RecordingSummary:
        """Write the summary, put all on the disk, and give the file its name; twice is once."""
        if self._summary is None:
            self._summary = self._finished(disk_full=False)
        return self._summary

    def discard(self) -> None:
        """Take the recording back: nothing of it is left."""
        self._file.abandon()
        active_path(self.path).unlink()

    def remove(self) -> None:
        """Take the recording back, even where a full disk has ended it: nothing of it is left."""
        if self._summary is None:
            self.discard()
        else:
            self.path.unlink()

    def _started(self, *, resume: bool) -> McapAppender:
        descriptor = self._file.descriptor
        try:
            with self._file.writing():
                if resume:
                    return McapAppender.resume(descriptor, LIBRARY)
                return McapAppender.start(descriptor, LIBRARY)
        except RecordingError:
            self._file.abandon()
            raise

    def _write(
        self,
        sensor: str,
        topic: Topic,
        sequence: int,
        log_time_ns: int,
        publish_time_ns: int,
        parts: tuple[Buffer, ...],
    ) -> None:
        with self._writing():
            if topic is Topic.IMAGE:
                self._file.ensure_space(sum(map(len, parts)) + self._reserve_bytes)
            channel = self._channel(sensor, topic)
            message = Message(channel, sequence, log_time_ns, publish_time_ns, parts)
            self._appender.add_message(message)

    def _channel(self, sensor: str, topic: Topic) -> int:
        """Return the channel of a topic, which its first message brings into the file."""
        index, name = self._appender.index, topic_name(sensor, topic)
        known = index.channel_of(name)
        if known is not None:
            return known
        schema_name, encoding, data = schema_of(topic)
        schema = index.schema_of(schema_name)
        if schema is None:
            schema = len(index.schemas) + 1
            self._appender.add(Schema(schema, data, encoding, schema_name))
        channel = len(index.channels) + 1
        self._appender.add(Channel(channel, name, message_encoding(topic), {}, schema))
        return channel

    def _write_start(
        self, metadata: Mapping[str, Mapping[str, str]], attachments: Mapping[str, bytes]
    ) -> None:
        """Write what stands before the messages, unless a writer that died has done so."""
        index = self._appender.index
        for name in metadata.keys() - index.metadata_names:
            self.write_metadata(name, metadata[name])
        for name in attachments.keys() - index.attachment_names:
            self.write_attachment(name, attachments[name])

    @contextlib.contextmanager
    def _writing(self) -> Generator[None, None, None]:
        """Let one record be written; where there is no space for it, end the recording whole."""
        if self._summary is not None:
            raise RecordingError(f"{self.path} is finished; nothing more can be written to it")
        try:
            with self._file.writing():
                yield
        except DiskFull as error:
            self._summary = self._finished(disk_full=True)
            count = sum(self._summary.frames.values())
            raise DiskFull(f"{error}; it was ended after {count} frames and is whole") from error

    def _finished(self, *, disk_full: bool) -> RecordingSummary:
        self._file.stop_syncing()
        with self._file.writing():
            self._appender.finish(self._last_words() if disk_full else ())
        self._file.publish()
        return RecordingSummary(
            path=self.path,
            frames=self._count(Topic.IMAGE),
            events=sum(self._count(Topic.EVENTS).values()),
            size_bytes=self.path.stat().st_size,
            disk_full=disk_full,
        )

    def _last_words(self) -> list[Message]:
        """Return the messages that say why the recording ends."""
        now = self._now_ns()
        body = Event(EventKind.DISK_FULL, now, "no space left; the recording ends here").message()
        channels = channels_of(self._appender.index.channels.values(), Topic.EVENTS)
        return [Message(channel, 0, now, now, (body,)) for channel in channels]

    def _count(self, topic: Topic) -> dict[str, int]:
        index = self._appender.index
        return {
            sensor: index.messages_on(index.channels[channel].topic)
            for channel, sensor in channels_of(index.channels.values(), topic).items()
        }


def _camera_message(sensor: str, camera: CameraNumbers, now_ns: int) -> bytes:
    """Return a foxglove.CameraCalibration: OpenCV's K and D, no rectification."""
    message = CameraCalibration(
        frame_id=sensor,
        width=camera.width,
        height=camera.height,
        distortion_model="plumb_bob",
        D=[camera.k1, camera.k2, camera.p1, camera.p2, camera.k3],
        K=[camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0],
        R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P=[camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )
    message.timestamp.FromNanoseconds(now_ns)
    return bytes(message.SerializeToString())
