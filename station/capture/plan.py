"""What is to be recorded, and how it went."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from station.recording import LOSSES, Event


class Trigger(StrEnum):
    """What starts an exposure."""

    FREE = "free"
    """The camera's own clock."""
    SOFTWARE = "software"
    """A command."""
    LINE1 = "Line1"
    """The camera's input line 1: a wheel."""


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

    def __post_init__(self) -> None:
        object.__setattr__(self, "trigger", Trigger(self.trigger))
        object.__setattr__(self, "path", self.path.absolute())  # another process writes it
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
        }

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> "RecordingPlan":
        """Make a plan of what `to_json` returned."""
        attachments = {
            name: base64.b64decode(content) for name, content in fields["attachments"].items()
        }
        return cls(**{**fields, "path": Path(fields["path"]), "attachments": attachments})


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

    @property
    def complete(self) -> bool:
        """Every frame that was triggered is in the file, and nothing is unexplained."""
        if any(event.kind in LOSSES for event in self.events):
            return False
        return self.lost == self.refused == 0 and self.triggered in {None, self.recorded}

    def summary(self) -> str:
        """Return the accounting in one line."""
        triggered = "" if self.triggered is None else f" of {self.triggered} triggered"
        parts = [f"{self.recorded} frames{triggered} recorded", f"{self.lost} lost"]
        parts += [f"{self.refused} refused"] if self.refused else []
        parts += [f"{self.repeated} repeated"] if self.repeated else []
        parts += [f"{self.resent_packets} packets resent"] if self.resent_packets else []
        verdict = "" if self.complete else "; not complete"
        return f"{self.path}: {', '.join(parts)}{verdict}"

    def to_json(self) -> dict[str, Any]:
        """Return the report as it leaves the capture process."""
        return {
            "path": str(self.path),
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
        return cls(**{**known, "path": Path(fields["path"]), "events": events})
