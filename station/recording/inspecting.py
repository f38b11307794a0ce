"""Looking through a file that somebody sent; run as a process of its own, which may die of it.

``python -m station.recording.inspecting FILE`` prints one JSON document: sensor, frames and lost
frames of a sound recording of one sensor, or why it is none.
"""

import json
import os
import re
import resource
import sys
from pathlib import Path

from station.errors import RecordingUnreadable, StationError
from station.recording.info import info
from station.recording.parts import ACCOUNTING, CONTINUED_IN, PART, SESSION
from station.recording.verify import verify

_SENSOR = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
_MEMORY_BYTES = 4 << 30
_CPU_S = 900
_NICE = 10


def inspect(path: Path) -> dict[str, str | int]:
    """Return what a recording of one sensor holds, after reading all of it.

    Raises
    ------
    RecordingUnreadable
        If it is damaged, one of several files, or not of one sensor.
    """
    report = verify(path)
    if not report.ok:
        raise RecordingUnreadable(
            f"the upload is damaged ({len(report.problems)} problems, the first: "
            f"{report.problems[0]}); `station recording recover` keeps what is sound"
        )
    found = info(path)
    part = found.metadata.get(SESSION, {}).get(PART, "1")
    if part != "1" or CONTINUED_IN in found.metadata.get(ACCOUNTING, {}):
        raise RecordingUnreadable(
            "the upload is one of several files of a recording; "
            "make them one with `station import FILE... --out whole.mcap`"
        )
    sensors = [one.sensor for one in found.sensors if one.frames]
    if len(sensors) != 1 or not _SENSOR.fullmatch(sensors[0]):
        raise RecordingUnreadable(
            f"the upload has pictures of {len(sensors)} sensors; upload the pictures of one, "
            "named with lower-case letters, digits, - and _"
        )
    return {"sensor": sensors[0], "frames": report.frames, "lost": report.lost}


def main(path: Path) -> None:
    """Print what is found, within limits that keep a hostile file from harming the host."""
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (_CPU_S, _CPU_S))
    os.nice(_NICE)  # a train may pass meanwhile
    found: dict[str, str | int]
    try:
        found = inspect(path)
    except StationError as error:
        # Where the station keeps its files is nobody's business.
        found = {"refused": str(error).replace(str(path), "the upload")}
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
