"""What other processes use, as the kernel counts it."""

import os
from dataclasses import dataclass
from pathlib import Path

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_USER_TIME, _SYSTEM_TIME = 11, 12  # fields of /proc/PID/stat behind the name, proc(5) less three


@dataclass(frozen=True, slots=True)
class Usage:
    """One process at one moment."""

    cpu_s: float
    """Seconds of processor that all its threads have used."""
    threads: int
    descriptors: int
    own_bytes: int
    """Memory that it shares with nobody: the ring is not in it."""


def usage_of(pid: int) -> Usage:
    """Read what a process uses; FileNotFoundError or ProcessLookupError where it has ended."""
    process = Path("/proc", str(pid))
    fields = (process / "stat").read_text().rpartition(")")[2].split()
    status = dict(
        line.split(":", 1) for line in (process / "status").read_text().splitlines() if ":" in line
    )
    return Usage(
        cpu_s=(int(fields[_USER_TIME]) + int(fields[_SYSTEM_TIME])) / _TICKS_PER_S,
        threads=int(status["Threads"]),
        descriptors=len(os.listdir(process / "fd")),
        own_bytes=int(status["RssAnon"].split()[0]) * 1024,
    )


def children_of(pid: int) -> list[int]:
    """Return the processes that the main thread of another one started."""
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def has_ended(pid: int) -> bool:
    """Whether a process is gone, or waits only to be reaped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True
