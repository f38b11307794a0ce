"""Having a file that somebody sent looked through, by a process that may die of it."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from station.errors import RecordingUnreadable

_PATIENCE_S = 1800.0


@dataclass(frozen=True, slots=True)
class Inspected:
    """What an uploaded recording holds."""

    sensor: str
    frames: int
    lost: int


def inspect_apart(path: Path) -> Inspected:
    """Return what a recording holds after reading all of it, in a process of its own.

    Raises
    ------
    RecordingUnreadable
        If it is no sound recording of one sensor.
    """
    command = [sys.executable, "-m", "station.recording.inspecting", str(path)]
    try:
        done = subprocess.run(
            command, capture_output=True, stdin=subprocess.DEVNULL, timeout=_PATIENCE_S, check=True
        )
        found = json.loads(done.stdout)
    except (subprocess.SubprocessError, ValueError) as error:
        raise RecordingUnreadable(
            "the upload cannot be read through; look at it with `station recording verify`"
        ) from error
    if "refused" in found:
        raise RecordingUnreadable(found["refused"])
    return Inspected(**found)
