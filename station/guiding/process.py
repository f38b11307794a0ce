"""The guiding process: it looks at pictures and solves on trial, until nobody asks any more."""

from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any, Final

from calib import CalibError
from station.errors import StationError
from station.guiding.guidance import guidance_of
from station.guiding.watch import SessionSoFar, SessionWatch
from station.pipeline import shifts_with
from station.processes.on_call import answer_calls
from station.report import calibration_report


def go_on(watch: SessionWatch, so_far: SessionSoFar) -> SessionSoFar:
    """Look at what has come since."""
    return watch.go_on(so_far)


WORK: Final[Mapping[str, Callable[..., Any]]] = {
    "go on": go_on,
    "guidance": guidance_of,
    "report": calibration_report,
    "shifts": shifts_with,
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


if __name__ == "__main__":
    answer_calls("guiding", serve)
