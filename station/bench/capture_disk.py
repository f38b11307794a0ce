"""A disk that fills up in the middle of a recording: a small tmpfs of the bench's own."""

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

from station.bench.figures import figure, none_of
from station.bench.small_disk import DISK_BYTES, SENDS
from station.errors import InputUnusable
from station.progress import Progress
from station.tables import Table

_TIMEOUT_S = 120.0
_FILL = "from station.bench.small_disk import main; main()"


def bench_full_disk(progress: Progress, folder: Path) -> Table:
    """Record onto a disk that is too small, then onto it again with room made."""
    progress(0.0, "a small disk")
    found, disk = _filled(folder)
    accounted, triggered = found["accounted"], found["triggered"]
    rows = [
        figure(
            f"recorded, lost and refused of {triggered} triggered",
            accounted,
            str(triggered),
            holds=accounted == triggered,
        ),
        figure(
            "frames in the file",
            found["in_file"],
            f"{found['recorded']}, as the report says",
            holds=0 < found["in_file"] == found["recorded"] < triggered,
        ),
        none_of("problems that verify finds", found["problems"]),
        none_of("frames that differ", found["different"]),
        figure("the report says why", found["said"], "yes", holds=found["said"]),
        figure("the file says why", found["said_in_file"], "yes", holds=found["said_in_file"]),
        figure("called complete", found["complete"], "no", holds=not found["complete"]),
        figure(
            "the next recording, with room made, is complete",
            found["again_complete"],
            "yes",
            holds=found["again_complete"],
        ),
    ]
    note = f"{DISK_BYTES / 1e6:g} MB: {disk}; {SENDS}."
    return Table("Disk full while recording", rows, (note,))


def _filled(folder: Path) -> tuple[dict[str, Any], str]:
    """Return what came of it, on a tmpfs where this user may mount one, else under a limit."""
    mount = folder / "small"
    mount.mkdir()
    record = [sys.executable, "-c", _FILL, str(mount)]
    script = f'mount -t tmpfs -o size={DISK_BYTES} none {shlex.quote(str(mount))} && exec "$@"'
    # Root needs no namespace of users, in which it would lose its rights over the network.
    space = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
    ways = {
        "a tmpfs of its own": [*space, "sh", "-c", script, "sh", *record],
        "a limit on the size of files": ["prlimit", f"--fsize={DISK_BYTES}", *record],
    }
    for name, command in ways.items():
        done = subprocess.run(  # noqa: S603  our own code in a space of its own
            command, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
        )
        if done.returncode == 0:
            return json.loads(done.stdout), name
    raise InputUnusable(
        f"no small disk could be made here: {done.stderr.strip().splitlines()[-1]}; run this part "
        "as root"
    )
