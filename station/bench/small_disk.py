"""Recording until the disk is full, and once more; for a process whose disk is small."""

import json
import sys
from pathlib import Path
from typing import Any

from station.bench.capture_rig import Format, Rig, differing
from station.capture import Trigger
from station.recording import EventKind, events, verify

SENDS = Format(width_px=1024, height_px=544, rate_hz=53.7)
DISK_BYTES = 48_000_000
_TRIGGERED = 150  # 84 MB
_AGAIN = 20
_NUMBER = 60


def fill(folder: Path) -> dict[str, Any]:
    """Record more than the disk holds, make room, and record again."""
    with Rig(folder, number=_NUMBER, sends=SENDS) as rig:
        rig.arm(Trigger.LINE1)
        rig.fire(_TRIGGERED)
        report = rig.client.finish(expected_frames=_TRIGGERED)
        proved = verify(rig.path)
        said = {event.kind for event in events(rig.path)}
        wrong = differing([rig.path], rig.served)
        rig.path.unlink()
        rig.arm(Trigger.LINE1)
        rig.fire(_AGAIN)
        again = rig.client.finish(expected_frames=_AGAIN)
    return {
        "triggered": _TRIGGERED,
        "recorded": report.recorded,
        "accounted": report.recorded + report.lost + report.refused,
        "in_file": proved.frames,
        "problems": len(proved.problems),
        "different": wrong,
        "said": EventKind.DISK_FULL in {event.kind for event in report.events},
        "said_in_file": EventKind.DISK_FULL in said,
        "complete": report.complete,
        "again_complete": again.complete,
    }


def main() -> None:
    """Fill the folder that is the process's one argument; print what came of it as JSON."""
    json.dump(fill(Path(sys.argv[1])), sys.stdout)
