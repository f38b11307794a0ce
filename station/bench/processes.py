"""What other processes use, as the kernel counts it."""

import os
from dataclasses import dataclass
from pathlib import Path

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# Fields of /proc/PID/stat behind the name, proc(5) less three.
_PARENT, _USER_TIME, _SYSTEM_TIME = 1, 11, 12
_TIMES_WITH_REAPED = slice(11, 15)  # these times, then those of children that were waited for


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


def parent_of(pid: int) -> int:
    """Return the process that another one belongs to: who started it, or who took it over."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[_PARENT])


def core_s_of_family(pid: int) -> float:
    """Return the processor seconds of a process and all that descend from it, also ended ones.

    A process that ends meanwhile is counted once its parent has waited for it, which is at once.
    """
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        threads = [int(name) for name in os.listdir(f"/proc/{pid}/task")]
        children = {
            int(word)
            for thread in threads
            for word in Path(f"/proc/{pid}/task/{thread}/children").read_text().split()
        }
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    own_s = sum(int(field) for field in fields[_TIMES_WITH_REAPED]) / _TICKS_PER_S
    return own_s + sum(core_s_of_family(child) for child in children)


def has_ended(pid: int) -> bool:
    """Whether a process is gone, or waits only to be reaped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True
