"""How the frames of a recording were exposed, and which of them show one pose."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from station.recording import Event, EventKind, events

_ALIKE = 0.01
"""Exposures that differ by less are one: cameras round."""


@dataclass(frozen=True, slots=True)
class Exposure:
    """How a frame of an exposure sequence was taken."""

    exposure_us: float
    gain_db: float
    laser: bool
    group: int
    """Counts the poses of a recording, from 1."""

    def differs_by_laser(self, other: "Exposure") -> bool:
        """Return whether the two frames differ by the laser alone."""
        longer = max(self.exposure_us, other.exposure_us)
        alike = abs(self.exposure_us - other.exposure_us) <= _ALIKE * longer
        return alike and self.gain_db == other.gain_db and self.laser is not other.laser


def exposures_in(path: Path) -> dict[tuple[int, int], Exposure]:
    """Return how frames were taken, by their id and how often that id had come by then.

    Only frames of exposure sequences are in it.

    Raises
    ------
    InputUnusable, RecordingUnreadable
        If the recording cannot be read.
    """
    found: dict[tuple[int, int], Exposure] = {}
    times: Counter[int] = Counter()
    for event in events(path):
        if event.kind is EventKind.EXPOSED and event.frame_id is not None:
            times[event.frame_id] += 1
            found[event.frame_id, times[event.frame_id]] = _exposure(event)
    return found


def _exposure(event: Event) -> Exposure:
    values = event.values
    return Exposure(
        exposure_us=float(values["exposure_us"]),
        gain_db=float(values["gain_db"]),
        laser=bool(values["laser"]),
        group=int(values["group"]),
    )
