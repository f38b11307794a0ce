"""What the capture process is doing."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any


class CaptureState(StrEnum):
    """States of a capture process."""

    UNAVAILABLE = "unavailable"
    """The camera is not open; it is tried again and again."""
    IDLE = "idle"
    """The camera is open and nothing is recorded."""
    RECORDING = "recording"
    """The camera acquires, what comes is recorded."""
    BLIND = "blind"
    """A recording is open and the camera lost; it is tried again and again."""
    RECORDED = "recorded"
    """What was planned is in the file; the report waits to be fetched."""


@dataclass(frozen=True, slots=True)
class CaptureStatus:
    """A capture process at one moment."""

    state: CaptureState
    sensor: str
    problem: str | None = None
    """Why the camera is not open."""
    camera: Mapping[str, str] = field(default_factory=dict)
    """What the camera is and how it is set."""
    session_id: str | None = None
    path: Path | None = None
    recording_s: float | None = None
    """How long the recording has been made, by a clock that nobody sets."""
    silent_s: float | None = None
    """How long ago its last frame came, or the recording began where none has come."""
    recorded: int = 0
    """By this process; one that goes on with a recording counts its own frames here."""
    lost: int = 0
    refused: int = 0
    repeated: int = 0
    resent_packets: int = 0
    ring_slots: int = 0
    """Places between camera and disk."""
    ring_waiting: int = 0
    """Of them, those that wait to be written."""
    clock: Mapping[str, str] = field(default_factory=dict)
    """How the camera's clock goes: see `ClockSummary.to_text`."""
    temperature_c: float | None = None
    """Of the camera, while nothing was recorded; None where it does not tell."""
    totals: Mapping[str, int] = field(default_factory=dict)
    """Frames by fate and packets resent since this process began."""
    warnings: tuple[str, ...] = ()
    """What lets frames come but is not as it should be."""

    def to_json(self) -> dict[str, Any]:
        """Return the status as it leaves the capture process."""
        return {
            "state": str(self.state),
            "sensor": self.sensor,
            "problem": self.problem,
            "camera": dict(self.camera),
            "session_id": self.session_id,
            "path": None if self.path is None else str(self.path),
            "recording_s": self.recording_s,
            "silent_s": self.silent_s,
            "recorded": self.recorded,
            "lost": self.lost,
            "refused": self.refused,
            "repeated": self.repeated,
            "resent_packets": self.resent_packets,
            "ring_slots": self.ring_slots,
            "ring_waiting": self.ring_waiting,
            "clock": dict(self.clock),
            "temperature_c": self.temperature_c,
            "totals": dict(self.totals),
            "warnings": list(self.warnings),
        }

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> "CaptureStatus":
        """Make a status of what `to_json` returned."""
        path = None if fields["path"] is None else Path(fields["path"])
        known = {
            "state": CaptureState(fields["state"]),
            "path": path,
            "warnings": tuple(fields["warnings"]),
        }
        return cls(**{**fields, **known})
