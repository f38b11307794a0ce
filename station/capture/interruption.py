"""Going on with a recording whose capture process was gone for a while."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from station.recording import Event, EventKind


@dataclass(frozen=True, slots=True)
class Interruption:
    """What is there of a recording, made whole, before another process goes on with it.

    Raises
    ------
    ValueError
        If a number is negative, or frames are said to be in no file.
    """

    files: int
    frames: int
    last_frame_id: int
    """Frames to come are numbered on behind it; 0 where none is there."""
    since_ns: int
    """When the last frame was received, or the recording began; UTC, this host's clock."""

    def __post_init__(self) -> None:
        if min(self.files, self.frames, self.last_frame_id, self.since_ns) < 0:
            raise ValueError(f"no number of an interruption is negative: {self}")
        if self.frames and not (self.files and self.last_frame_id):
            raise ValueError(f"frames are in a file and have an id: {self}")

    def to_json(self) -> dict[str, int]:
        """Return it as it goes to the capture process."""
        return asdict(self)

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> "Interruption":
        """Make one of what `to_json` returned."""
        return cls(**fields)

    def event(self, now_ns: int) -> Event:
        """Return what the next file begins with, the sensor being armed again by now."""
        behind = f"frame {self.last_frame_id}" if self.last_frame_id else "its beginning"
        seconds = max(0, now_ns - self.since_ns) / 1e9
        detail = (
            f"armed again {seconds:.2f} s after {behind}, the capture process having died: what "
            "was exposed meanwhile is lost or unknown"
        )
        values = {"since_ns": float(self.since_ns), "until_ns": float(now_ns)}
        return Event(EventKind.CAPTURE_BACK, now_ns, detail, values=values)
