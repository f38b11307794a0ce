"""What happened while recording: every loss, refusal and interruption, as it goes into the file."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class EventKind(StrEnum):
    """What an event is about."""

    STARTED = "started"
    """The recording began."""
    FRAMES_LOST = "frames_lost"
    """Frame ids are missing: the frames were exposed and never arrived."""
    FRAME_REFUSED = "frame_refused"
    """A frame arrived incomplete; it is not in the file."""
    FRAME_REPEATED = "frame_repeated"
    """A frame id came again or ran backward; the later one is not in the file."""
    FRAMES_DROPPED = "frames_dropped"
    """Frames arrived whole and could not be written."""
    FRAMES_MISCOUNTED = "frames_miscounted"
    """The number of triggers differs from the number of frames accounted for."""
    COUNTER_OFFSET = "counter_offset"
    """The camera's first frame id is not 1: a loss before it cannot be told."""
    PACKETS_RESENT = "packets_resent"
    """Packets were lost on the way and sent again."""
    RING_FULL = "ring_full"
    """Frames met no free place between camera and disk."""
    CAMERA_LOST = "camera_lost"
    """The camera stopped answering."""
    CAMERA_TAKEN = "camera_taken"
    """Another program took control of the camera."""
    CAMERA_BACK = "camera_back"
    """The camera was opened again; what it exposed in between is unknown."""
    CONTINUED_FROM = "continued_from"
    """The file goes on with a recording that began in another file."""
    CONTINUED_IN = "continued_in"
    """The recording goes on in a next file."""
    CLOCK_MISSING = "clock_missing"
    """The camera has no clock: times are those of reception."""
    CLOCK_SET = "clock_set"
    """The camera's clock was set anew; its offset is measured from here on."""
    PACKET_SIZE = "packet_size"
    """Packets of the size asked for do not come through, or are not proved to."""
    RECEIVE_BUFFER = "receive_buffer"
    """The system grants too little room for packets that wait: frames may be lost."""
    EXPOSED = "exposed"
    """How a frame of an exposure sequence was taken: see `values`."""
    RECORDER_RESTARTED = "recorder_restarted"
    """The recorder died and another went on with its file."""
    CAPTURE_LOST = "capture_lost"
    """The capture process died; the recorder finished the file."""
    CAPTURE_BACK = "capture_back"
    """Another capture process goes on; what was exposed in between is lost or unknown."""
    RECORDER_FAILED = "recorder_failed"
    """Nothing more could be written; the file ends here."""
    DISK_FULL = "disk_full"
    """No space was left; the file ends here."""
    RECOVERED = "recovered"
    """The file was found unfinished and made whole."""
    FINISHED = "finished"
    """The recording ended as asked."""


LOSSES = frozenset({
    EventKind.FRAMES_LOST,
    EventKind.FRAME_REFUSED,
    EventKind.FRAMES_DROPPED,
    EventKind.FRAMES_MISCOUNTED,
    EventKind.CAMERA_LOST,
    EventKind.CAMERA_TAKEN,
    EventKind.CAPTURE_LOST,
    EventKind.CAPTURE_BACK,
    EventKind.DISK_FULL,
    EventKind.RECORDER_FAILED,
    EventKind.RECOVERED,
})
"""A recording with one of these is not complete."""

EVENT_SCHEMA_NAME = "treadline.Event"
EVENT_SCHEMA = json.dumps({
    "title": EVENT_SCHEMA_NAME,
    "type": "object",
    "properties": {
        "kind": {"type": "string", "enum": list(EventKind)},
        "frame_id": {
            "type": ["integer", "null"],
            "description": "first frame concerned, as the camera numbers them",
        },
        "count": {"type": "integer", "description": "frames (or packets) concerned"},
        "detail": {"type": "string"},
        "values": {
            "type": "object",
            "description": "of an `exposed` frame: exposure_us, gain_db, laser, group, step; "
            "of `capture_back`: since_ns, until_ns",
        },
    },
    "required": ["kind", "frame_id", "count", "detail"],
}).encode()
"""JSON schema of an event message; its time is the message's log time."""


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that happened, at `time_ns` (UTC, ns since 1970, this host's clock)."""

    kind: EventKind
    time_ns: int
    detail: str = ""
    frame_id: int | None = None
    """The first frame concerned, as the camera numbers them."""
    count: int = 0
    """How many frames (or packets) it concerns."""
    values: Mapping[str, float] = field(default_factory=dict)
    """Numbers by name, where the kind has some."""

    def __post_init__(self) -> None:
        if not (self.time_ns >= 0 and self.count >= 0):
            raise ValueError(f"time and count must not be negative: {self}")

    def message(self) -> bytes:
        """Return the body of the event's message in a recording."""
        fields = self.to_json()
        del fields["time_ns"]
        return json.dumps(fields).encode()

    @classmethod
    def from_message(cls, body: bytes | memoryview, time_ns: int) -> "Event":
        """Read the body of an event's message; ValueError where it is none."""
        fields = json.loads(bytes(body))
        return cls.from_json({**fields, "time_ns": time_ns})

    def to_json(self) -> dict[str, Any]:
        """Return the event as JSON carries it between processes."""
        fields = {
            "kind": str(self.kind),
            "time_ns": self.time_ns,
            "detail": self.detail,
            "frame_id": self.frame_id,
            "count": self.count,
        }
        return fields | ({"values": dict(self.values)} if self.values else {})

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> "Event":
        """Make an event of what `to_json` returned."""
        try:
            return cls(
                EventKind(fields["kind"]),
                int(fields["time_ns"]),
                str(fields["detail"]),
                fields["frame_id"],
                int(fields["count"]),
                dict(fields.get("values", {})),
            )
        except (KeyError, TypeError) as error:
            raise ValueError(f"not an event: {fields!r}") from error
