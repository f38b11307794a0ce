"""The topics of a recording, one of each kind per sensor, and their schemas."""

from collections.abc import Iterable
from enum import StrEnum

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.records import Channel

from station.recording.events import EVENT_SCHEMA, EVENT_SCHEMA_NAME


class Topic(StrEnum):
    """What a topic carries."""

    IMAGE = "image"
    """Pictures, foxglove.RawImage."""
    CALIBRATION = "calibration"
    """The camera model in force, foxglove.CameraCalibration."""
    EVENTS = "events"
    """What happened, JSON."""


def topic_name(sensor: str, topic: Topic) -> str:
    """Return the topic's name in the file.

    Examples
    --------
    >>> topic_name("left", Topic.IMAGE)
    '/left/image'
    """
    return f"/{sensor}/{topic}"


def parse_topic(name: str) -> tuple[str, Topic] | None:
    """Return the sensor and the kind of a topic, or None where it is none of ours.

    Examples
    --------
    >>> parse_topic("/left/events")
    ('left', <Topic.EVENTS: 'events'>)
    >>> parse_topic("/rosout") is None
    True
    """
    _, _, rest = name.partition("/")
    sensor, _, kind = rest.rpartition("/")
    return (sensor, Topic(kind)) if sensor and kind in set(Topic) else None


def channels_of(channels: Iterable[Channel], topic: Topic) -> dict[int, str]:
    """Return the sensors of the channels that carry one kind of topic, by channel id."""
    parsed = {channel.id: parse_topic(channel.topic) for channel in channels}
    return {id_: found[0] for id_, found in parsed.items() if found and found[1] is topic}


def schema_of(topic: Topic) -> tuple[str, str, bytes]:
    """Return name, encoding and data of the topic's schema."""
    match topic:
        case Topic.EVENTS:
            return EVENT_SCHEMA_NAME, "jsonschema", EVENT_SCHEMA
        case Topic.IMAGE:
            message = RawImage.DESCRIPTOR
        case Topic.CALIBRATION:
            message = CameraCalibration.DESCRIPTOR
    return message.full_name, "protobuf", _with_dependencies(message.file).SerializeToString()


def message_encoding(topic: Topic) -> str:
    """Return how the topic's messages are encoded."""
    return "json" if topic is Topic.EVENTS else "protobuf"


def _with_dependencies(file: FileDescriptor) -> FileDescriptorSet:
    """Return a schema's file and all it needs, dependencies first, as readers want it."""
    files: dict[str, FileDescriptor] = {}

    def visit(one: FileDescriptor) -> None:
        for dependency in one.dependencies:
            visit(dependency)
        files.setdefault(one.name, one)

    visit(file)
    collected = FileDescriptorSet()
    for one in files.values():
        one.CopyToProto(collected.file.add())
    return collected
