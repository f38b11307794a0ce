"""Reading a finished recording: its frames, its events, and what is in it."""

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.records import Attachment, ChunkIndex, Metadata
from zlib_ng.zlib_ng import crc32

from station.errors import NotFound
from station.recording.chunks import StoredMessage, messages, read_chunk
from station.recording.events import Event
from station.recording.layout import DAMAGED, PREFIX
from station.recording.opening import Recording, open_recording
from station.recording.rawimage import read_raw_image
from station.recording.soundness import ensure_sound_around_chunks
from station.recording.topics import Topic, channels_of, parse_topic

if TYPE_CHECKING:  # importing `calib` would make a new recorder late by half a second
    from calib import Picture

_ENCODINGS = frozenset({"mono8", "8UC1"})  # two names of one thing


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrame:
    """One frame of a recording."""

    sensor: str
    frame_id: int
    """As the camera numbers them, from 1."""
    camera_time_ns: int
    """When it was exposed, UTC."""
    host_time_ns: int
    """When it was received, by this host's clock, UTC."""
    picture: "Picture"
    """Shape (H, W), read-only."""
    exposure_us: float | None
    """Exposure time, where the recording says it."""


def frames(
    path: Path, sensor: str | None = None, *, validate: bool = True
) -> Iterator[RecordedFrame]:
    """Yield the frames of a recording in the order they were written, one in memory at a time.

    Parameters
    ----------
    path
        A finished recording.
    sensor
        Only this sensor's frames.
    validate
        Compute the checksums of every chunk and of all around them; without, a flipped bit passes.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is not a whole recording, or where it is damaged when that is reached.
    """
    with open_recording(path) as recording:
        if validate:
            ensure_sound_around_chunks(recording)
        yield from frames_in(recording, sensor, validate=validate)


def frames_in(
    recording: Recording, sensor: str | None = None, *, validate: bool = True
) -> Iterator[RecordedFrame]:
    """Yield the frames in the chunks of an open recording; see `frames`."""
    exposures = {name: _exposure_us(recording, name) for name in sensors_in(recording)}
    for name, message in _stored(recording, Topic.IMAGE, sensor, validate=validate):
        yield _frame(recording, name, message, exposures[name])


def events(path: Path, sensor: str | None = None) -> list[Event]:
    """Return the events of a recording, in the order they were written."""
    found = []
    with open_recording(path) as recording:
        for _, message in _stored(recording, Topic.EVENTS, sensor, validate=True):
            try:
                found.append(Event.from_message(message.data, message.log_time_ns))
            except DAMAGED as error:
                raise recording.damaged("in an event", error) from error
    return found


def attachment(path: Path, name: str) -> bytes:
    """Return a file put into the recording; NotFound where there is none of that name."""
    with open_recording(path) as recording:
        for index in recording.attachments:
            if index.name == name:
                return _attachment(recording, index.offset, index.length)
        names = ", ".join(index.name for index in recording.attachments) or "none"
    raise NotFound(f"{path}: no attachment {name!r}; it has: {names}")


def sensors_in(recording: Recording) -> list[str]:
    """Return the sensors that have topics in the recording."""
    topics = (parse_topic(channel.topic) for channel in recording.channels.values())
    return sorted({topic[0] for topic in topics if topic is not None})


def metadata_of(recording: Recording) -> dict[str, dict[str, str]]:
    """Return the metadata records by name."""
    found = {}
    for index in recording.metadata:
        body = recording.read(index.offset, index.length)[PREFIX.size :]
        try:
            record = Metadata.read(ReadDataStream(BytesIO(body)))
        except DAMAGED as error:
            raise recording.damaged(f"in the metadata {index.name!r}", error) from error
        found[record.name] = dict(record.metadata)
    return found


def _stored(
    recording: Recording, topic: Topic, sensor: str | None, *, validate: bool
) -> Iterator[tuple[str, StoredMessage]]:
    """Yield (sensor, message) of one kind of topic; chunks without it are not read."""
    channels = channels_of(recording.channels.values(), topic)
    wanted = {id_: name for id_, name in channels.items() if sensor in {None, name}}
    for chunk in recording.chunks:
        if chunk.message_index_offsets and wanted.keys().isdisjoint(chunk.message_index_offsets):
            continue
        for message in _messages(recording, chunk, validate=validate):
            if message.channel in wanted:
                yield wanted[message.channel], message


def _messages(
    recording: Recording, chunk: ChunkIndex, *, validate: bool
) -> Iterator[StoredMessage]:
    try:
        yield from messages(read_chunk(recording.descriptor, chunk, validate=validate))
    except DAMAGED as error:
        raise recording.damaged(f"at byte {chunk.chunk_start_offset}", error) from error


def _frame(
    recording: Recording, sensor: str, message: StoredMessage, exposure_us: float | None
) -> RecordedFrame:
    return RecordedFrame(
        sensor=sensor,
        frame_id=message.sequence,
        camera_time_ns=message.publish_time_ns,
        host_time_ns=message.log_time_ns,
        picture=picture_of(recording, message),
        exposure_us=exposure_us,
    )


def picture_of(recording: Recording, message: StoredMessage) -> "Picture":
    """Return the picture in a message, read-only; RecordingUnreadable where it holds none."""
    try:
        image = read_raw_image(message.data)
        if image.encoding not in _ENCODINGS:
            raise ValueError(f"encoding {image.encoding!r}; mono8 is read")
        pixels = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    except DAMAGED as error:
        raise recording.damaged(f"in frame {message.sequence}", error) from error
    return pixels[:, : image.width]


def _exposure_us(recording: Recording, sensor: str) -> float | None:
    """Return the exposure time in the camera's settings, where the recording has them."""
    for name, values in metadata_of(recording).items():
        if name.startswith("camera") and values.get("sensor", sensor) == sensor:
            try:
                return float(values["exposure_us"])
            except (KeyError, ValueError):
                return None
    return None


def _attachment(recording: Recording, offset: int, length: int) -> bytes:
    record = recording.read(offset, length)
    try:
        found = Attachment.read(ReadDataStream(BytesIO(record[PREFIX.size :])))
        crc = int.from_bytes(record[-4:], "little")
        if crc and crc32(record[PREFIX.size : -4]) != crc:
            raise ValueError("its checksum does not match")
    except DAMAGED as error:
        raise recording.damaged("in an attachment", error) from error
    return bytes(found.data)
