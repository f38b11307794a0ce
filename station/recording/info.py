"""What is in a recording, without reading its pictures."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from station.recording.opening import Recording, open_recording
from station.recording.reader import metadata_of, sensors_in
from station.recording.soundness import ensure_sound_around_chunks
from station.recording.topics import Topic, topic_name


@dataclass(frozen=True, slots=True)
class SensorInfo:
    """One sensor's part of a recording."""

    sensor: str
    frames: int
    events: int


@dataclass(frozen=True, slots=True)
class RecordingInfo:
    """What a recording holds."""

    path: Path
    size_bytes: int
    start_ns: int
    """Log time of the first message, UTC; 0 where there is none."""
    end_ns: int
    sensors: tuple[SensorInfo, ...]
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, int]
    """Sizes in bytes by name."""

    @property
    def duration_s(self) -> float:
        """Time from the first message to the last."""
        return (self.end_ns - self.start_ns) / 1e9

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {
            "path": str(self.path),
            "size_bytes": self.size_bytes,
            "start_ns": self.start_ns,
            "end_ns": self.end_ns,
            "duration_s": self.duration_s,
            "sensors": [
                {"sensor": one.sensor, "frames": one.frames, "events": one.events}
                for one in self.sensors
            ],
            "metadata": self.metadata,
            "attachments": self.attachments,
        }


def info(path: Path) -> RecordingInfo:
    """Return what a finished recording holds, from its summary.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If it is not a whole recording, or damaged elsewhere than in a picture.
    """
    with open_recording(path) as recording:
        ensure_sound_around_chunks(recording)
        return RecordingInfo(
            path=path,
            size_bytes=recording.size_bytes,
            start_ns=recording.statistics.message_start_time,
            end_ns=recording.statistics.message_end_time,
            sensors=tuple(_sensor(recording, name) for name in sensors_in(recording)),
            metadata=metadata_of(recording),
            attachments={one.name: one.data_size for one in recording.attachments},
        )


def _sensor(recording: Recording, sensor: str) -> SensorInfo:
    return SensorInfo(
        sensor,
        frames=_count(recording, topic_name(sensor, Topic.IMAGE)),
        events=_count(recording, topic_name(sensor, Topic.EVENTS)),
    )


def _count(recording: Recording, topic: str) -> int:
    counts = recording.statistics.channel_message_counts
    return sum(
        counts.get(channel.id, 0)
        for channel in recording.channels.values()
        if channel.topic == topic
    )
