"""Looking through a file that somebody sent, in a process that may die of it."""

import os
import re
import resource
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

from station.errors import RecordingUnreadable
from station.processes.pool import pool_of_processes
from station.recording import info, verify

_SENSOR = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
_MEMORY_BYTES = 4 << 30
_CPU_S = 900
_NICE = 10


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
        If it is no sound recording of one sensor; without the name of the file, which is ours.
    """
    with pool_of_processes(1) as pool:
        try:
            return pool.submit(_inspect, path).result()
        except RecordingUnreadable as error:
            raise RecordingUnreadable(str(error).replace(f"{path}", "the upload")) from None
        except (BrokenProcessPool, MemoryError, OSError, ValueError, OverflowError) as error:
            raise RecordingUnreadable(
                f"the upload cannot be read through ({type(error).__name__}); "
                "look at it with `station recording verify`"
            ) from error


def _inspect(path: Path) -> Inspected:
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (_CPU_S, _CPU_S))
    os.nice(_NICE)  # a train may pass meanwhile
    report = verify(path)
    if not report.ok:
        raise RecordingUnreadable(
            f"the upload is damaged ({len(report.problems)} problems, the first: "
            f"{report.problems[0]}); `station recording recover` keeps what is sound"
        )
    found = info(path)
    said = found.metadata
    if said.get("session", {}).get("part", "1") != "1" or "continued_in" in said.get(
        "accounting", {}
    ):
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
    return Inspected(sensors[0], frames=report.frames, lost=report.lost)
