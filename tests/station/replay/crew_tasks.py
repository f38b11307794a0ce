"""Work that workers import: each does to its worker what the name says."""

import os
import signal
import time
from pathlib import Path

from station.replay.work import OtherSoftware


def double(number):
    return 2 * number


def note_and_double(task):
    """Leave a file that tells of this attempt."""
    folder, number = task
    Path(folder, f"{number}.{os.getpid()}.{time.monotonic_ns()}").touch()
    time.sleep(0.05)
    return 2 * number


def die_once(task):
    folder, number = task
    mark = Path(folder, "died")
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return note_and_double(task)


def die_of_three(number):
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * number


def fail_of_three(number):
    if number == 3:
        raise ZeroDivisionError("three\nis too much")
    return 2 * number


def refuse(_number):
    raise OtherSoftware("a worker runs treadline 0")
