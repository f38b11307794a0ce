"""The guiding process: it looks at pictures and solves on trial, until nobody asks any more."""

import signal
import sys
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final, cast

from calib import CalibError
from station.errors import StationError
from station.guiding.guidance import guidance_of
from station.guiding.watch import SessionSoFar, SessionWatch
from station.processes.beginning import begin_process
from station.processes.one_core import use_one_core
from station.processes.priority import yield_to_others
from station.report import calibration_report
from station.settings import LogLevel


def go_on(watch: SessionWatch, so_far: SessionSoFar) -> SessionSoFar:
    """Look at what has come since."""
    return watch.go_on(so_far)


WORK: Final[Mapping[str, Callable[..., Any]]] = {
    "go on": go_on,
    "guidance": guidance_of,
    "report": calibration_report,
}
"""What can be asked for, by name."""


def serve(link: Connection, idle_s: float) -> None:
    """Answer question after question, until the asking end is closed or is silent for so long.

    What goes over the link is pickled: both its ends are the station's own, and nobody else's.
    """
    try:
        while link.poll(idle_s):
            work, given = link.recv()
            link.send(_answer(WORK[work], given))
    except (EOFError, ConnectionError):
        return


def _answer(work: Callable[..., Any], given: tuple[Any, ...]) -> tuple[Any, StationError | None]:
    try:
        return work(*given), None
    except StationError as error:
        return None, type(error)(str(error))
    except CalibError as error:  # callers there know the station's errors alone
        return None, StationError(str(error))


def main(link_descriptor: int, idle_s: float, level: LogLevel, lock: Path) -> None:
    """Be the guiding process.

    It has nothing to finish: a service manager's TERM ends it where it is, and Ctrl-C at a terminal
    is for the process that answers calls, whose end closes the link.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield_to_others()
    use_one_core()
    begin_process("guiding", level, lock)
    serve(Connection(link_descriptor), idle_s)


if __name__ == "__main__":
    descriptor_given, idle_given, level_given, lock_given = sys.argv[1:5]
    main(
        int(descriptor_given),
        float(idle_given),
        cast(LogLevel, level_given),
        Path(lock_given),
    )
