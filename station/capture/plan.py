"""What is to be recorded, and how it went."""

import base64
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from station.capture.interruption import Interruption
from station.recording import LOSSES, Event, EventKind, Rotation

_REASONS = LOSSES & {
    EventKind.CAMERA_LOST,
    EventKind.CAPTURE_LOST,
    EventKind.DISK_FULL,
    EventKind.RECOVERED,
}
"""Why frames are missing, beside how many."""


class Trigger(StrEnum):
    """What starts an exposure."""

    FREE = "free"
    """The camera's own clock."""
    SOFTWARE = "software"
    """A command."""
    LINE1 = "Line1"
    """The camera's input line 1: a wheel."""


@dataclass(frozen=True, slots=True)
class ExposureStep:
    """How one frame of an exposure sequence is taken."""

    exposure_us: float
    gain_db: float | None = None
    """The camera's present gain where None."""
    laser: bool = True

    def __post_init__(self) -> None:
        if not (self.exposure_us > 0.0):
            raise ValueError(f"exposure_us must be more than 0, got {self.exposure_us}")


@dataclass(frozen=True, slots=True)
class RecordingPlan:
    """One recording to make.

    Without `frames` and `seconds` it goes on until it is finished by command.
    """

    session_id: str
    path: Path
    sensor: str
    trigger: Trigger = Trigger.LINE1
    frames: int | None = None
    """Stop after so many frames; lost ones count."""
    seconds: float | None = None
    """Stop after so many seconds."""
    metadata: Mapping[str, str] = field(default_factory=dict)
    """Names and values for the session's record."""
    attachments: Mapping[str, bytes] = field(default_factory=dict)
    """Files to put in; ``calibration.json`` also becomes the sensor's calibration topic."""
    sequence: tuple[ExposureStep, ...] = ()
    """What each software trigger takes, one frame after the other; one frame where empty."""
    rotation: Rotation = field(default_factory=Rotation)
    """When the recording goes on in a next file; in one file without."""
    reserve_bytes: int = 0
    """Space on the disk that no frame takes."""
    goes_on: Interruption | None = None
    """What is there already, where a process that is gone had begun the recording."""
    looks: bool = False
    """Whether the camera may be looked through between two triggers: between poses of a target, not
    while wheels come."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "trigger", Trigger(self.trigger))
        object.__setattr__(self, "path", self.path.absolute())  # another process writes it
        object.__setattr__(self, "sequence", tuple(self.sequence))
        if self.sequence and self.trigger is not Trigger.SOFTWARE:
            raise ValueError("an exposure sequence needs the trigger `software`")
        if self.looks and self.trigger is not Trigger.SOFTWARE:
            raise ValueError("looks between two triggers need the trigger `software`")
        if not (self.frames is None or self.frames > 0):
            raise ValueError(f"frames must be 1 or more, got {self.frames}")
        if not (self.seconds is None or self.seconds > 0.0):
            raise ValueError(f"seconds must be more than 0, got {self.seconds}")

    def to_json(self) -> dict[str, Any]:
        """Return the plan as it goes to the capture process."""
        return {
            "session_id": self.session_id,
            "path": str(self.path),
            "sensor": self.sensor,
            "trigger": str(self.trigger),
            "frames": self.frames,
            "seconds": self.seconds,
            "metadata": dict(self.metadata),
            "attachments": {
                name: base64.b64encode(content).decode()
                for name, content in self.attachments.items()
            },
            "sequence": [asdict(step) for step in self.sequence],
            "rotation": asdict(self.rotation),
            "reserve_bytes": self.reserve_bytes,
            "goes_on": None if self.goes_on is None else self.goes_on.to_json(),
            "looks": self.looks,
        }

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> "RecordingPlan":
        """Make a plan of what `to_json` returned."""
        attachments = {
            name: base64.b64decode(content) for name, content in fields["attachments"].items()
        }
        rotation = Rotation(**fields.get("rotation", {}))
        before = fields.get("goes_on")
        known = {
            "path": Path(fields["path"]),
            "attachments": attachments,
            "rotation": rotation,
            "goes_on": None if before is None else Interruption.from_json(before),
            "sequence": tuple(ExposureStep(**step) for step in fields.get("sequence", ())),
        }
        return cls(**{**fields, **known})


@dataclass(frozen=True, slots=True)
class CaptureReport:
    """How a recording went: recorded + lost + refused is what was triggered, always."""

    path: Path
    triggered: int | None
    """Exposures, as the controller or the software trigger counted them; None where nobody did."""
    recorded: int
    lost: int
    """Frames that never arrived, or arrived and could not be written."""
    refused: int
    """Frames that arrived incomplete."""
    repeated: int
    """Frames that came again or out of order; not in the file, not among the triggered."""
    resent_packets: int
    first_time_ns: int | None
    """Camera time of the first recorded frame, UTC."""
    last_time_ns: int | None
    events: tuple[Event, ...]
    paths: tuple[Path, ...] = ()
    """The files of the recording in order; `path` is the first."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "paths", tuple(self.paths) or (self.path,))

    @property
    def interrupted(self) -> bool:
        """Whether the capture process had died in the middle and another went on."""
        return any(event.kind is EventKind.CAPTURE_BACK for event in self.events)

    @property
    def complete(self) -> bool:
        """Every frame that was triggered is in the file, and nothing is unexplained."""
        kinds = {event.kind for event in self.events}
        if kinds & LOSSES:
            return False
        if self.triggered is None and EventKind.COUNTER_OFFSET in kinds:
            return False  # what came before the first id, nobody can tell
        return self.lost == self.refused == 0 and self.triggered in {None, self.recorded}

    def summary(self) -> str:
        """Return the accounting in one line."""
        triggered = "" if self.triggered is None else f" of {self.triggered} triggered"
        files = "" if len(self.paths) == 1 else f" in {len(self.paths)} files"
        parts = [f"{self.recorded} frames{triggered} recorded{files}", f"{self.lost} lost"]
        parts += [f"{self.refused} refused"] if self.refused else []
        parts += [f"{self.repeated} repeated"] if self.repeated else []
        parts += [f"{self.resent_packets} packets resent"] if self.resent_packets else []
        parts += ["gone on with after the capture process died"] if self.interrupted else []
        why = dict.fromkeys(e.kind.replace("_", " ") for e in self.events if e.kind in _REASONS)
        verdict = "" if self.complete else "; not complete" + "".join(f", {each}" for each in why)
        return f"{self.path}: {', '.join(parts)}{verdict}"

    def to_json(self) -> dict[str, Any]:
        """Return the report as it leaves the capture process."""
        return {
            "path": str(self.path),
            "paths": [str(path) for path in self.paths],
            "triggered": self.triggered,
            "recorded": self.recorded,
            "lost": self.lost,
            "refused": self.refused,
            "repeated": self.repeated,
            "resent_packets": self.resent_packets,
            "first_time_ns": self.first_time_ns,
            "last_time_ns": self.last_time_ns,
            "complete": self.complete,
            "events": [event.to_json() for event in self.events],
        }

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> "CaptureReport":
        """Make a report of what `to_json` returned."""
        known = {name: value for name, value in fields.items() if name != "complete"}
        events = tuple(Event.from_json(event) for event in fields["events"])
        paths = tuple(Path(path) for path in fields.get("paths", ()))
        return cls(**{**known, "path": Path(fields["path"]), "paths": paths, "events": events})
