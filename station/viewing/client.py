"""Asking the viewing process, which is started when it is needed and again when it died."""

import json
import threading
from multiprocessing.connection import Connection
from multiprocessing.reduction import send_handle
from pathlib import Path
from typing import Any

import structlog

from station import errors
from station.errors import StationError
from station.processes.on_call import ProcessOnCall
from station.settings import LogLevel
from station.viewing.orders import SeenFrame, View, ViewOrder

_IDLE_S = 60.0
_PATIENCE_S = 20.0
"""Behind a train that is measured on all cores a start takes seconds."""
_ATTEMPTS = 2
_log = structlog.get_logger()


class ViewerLost(StationError):
    """The viewing process died over a picture, or did not answer."""

    retry_after_s = 1


class Viewer:
    """The way to the viewing process; threads that ask at the same time take turns.

    Parameters
    ----------
    level
        What the process logs.
    lock
        The file of whose lock every process of the station holds a share.
    idle_s
        The process ends by itself when nobody has asked it for so long.
    patience_s
        How long a picture may take; a process that needs longer is ended.
    """

    def __init__(
        self,
        level: LogLevel,
        lock: Path,
        *,
        idle_s: float = _IDLE_S,
        patience_s: float = _PATIENCE_S,
    ) -> None:
        self._process = ProcessOnCall("station.viewing.process", level, lock, idle_s)
        self._patience_s = patience_s
        self._turn = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Process id of the viewing process; None where there is none."""
        return self._process.pid

    def view(self, order: ViewOrder) -> View | None:
        """Return a frame as ordered; None where it is the one that the caller has.

        Raises
        ------
        StationError
            What the viewing process answers with, as NotFound where there is no such frame.
        ViewerLost
            If it died over the picture, twice, or did not answer.
        """
        with self._turn:
            for _ in range(_ATTEMPTS):
                try:
                    return self._asked(self._process.link(), order)
                except (EOFError, OSError):
                    # It may have ended by itself while the order was on its way.
                    self._process.end()
        raise ViewerLost("the viewing process died over the picture; try again, or see the log")

    def close(self) -> None:
        """End the viewing process; the next order starts another."""
        with self._turn:
            self._process.end()

    def _asked(self, link: Connection, order: ViewOrder) -> View | None:
        """Ask; EOFError or OSError where the process is gone."""
        link.send_bytes(json.dumps(order.to_json()).encode())
        if order.shared is not None:
            send_handle(link, order.shared.descriptor, self._process.pid)
        answer = json.loads(self._received(link))
        if "error" in answer:
            raise _error(answer)
        if "same" in answer:
            return None
        return View(SeenFrame(**answer["frame"]), order.form, self._received(link))

    def _received(self, link: Connection) -> bytes:
        if not link.poll(self._patience_s):
            self._process.end()
            _log.warning("the viewing process did not answer", waited_s=self._patience_s)
            raise ViewerLost(f"no picture came within {self._patience_s:g} s; is the disk stuck?")
        return link.recv_bytes()


def _error(answer: dict[str, Any]) -> StationError:
    kind = getattr(errors, answer["error"], StationError)
    error: StationError = kind(answer["message"])
    return error
