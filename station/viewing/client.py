"""Asking the viewing process, which is started when it is needed and again when it died."""

import json
import socket
import subprocess
import sys
import threading
from multiprocessing.connection import Connection
from multiprocessing.reduction import send_handle
from pathlib import Path
from typing import Any

import structlog

from station import errors
from station.errors import StationError
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
        self._arguments = (str(idle_s), level, str(lock))
        self._patience_s = patience_s
        self._turn = threading.Lock()
        self._running: _Running | None = None

    @property
    def pid(self) -> int | None:
        """Process id of the viewing process; None where there is none."""
        running = self._running
        return None if running is None or not running.lives else running.pid

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
                running = self._ensure_running()
                try:
                    return running.view(order, self._patience_s)
                except (EOFError, OSError):
                    # It may have ended by itself while the order was on its way.
                    self._end()
        raise ViewerLost("the viewing process died over the picture; try again, or see the log")

    def close(self) -> None:
        """End the viewing process; the next order starts another."""
        with self._turn:
            self._end()

    def _ensure_running(self) -> "_Running":
        if self._running is not None and not self._running.lives:
            self._end()
        if self._running is None:
            self._running = _Running(self._arguments)
        return self._running

    def _end(self) -> None:
        if self._running is not None:
            self._running.end()
        self._running = None


class _Running:
    """A viewing process."""

    def __init__(self, arguments: tuple[str, ...]) -> None:
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-m", "station.viewing.process", str(theirs.fileno())]
        self._process = subprocess.Popen(  # noqa: S603  our own code
            [*command, *arguments], pass_fds=(theirs.fileno(),), stdin=subprocess.DEVNULL
        )
        theirs.close()
        self._link = Connection(ours.detach())
        # One that ends by itself is buried at once, not when the next picture is wanted.
        threading.Thread(target=self._process.wait, name="viewing ended", daemon=True).start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def lives(self) -> bool:
        return self._process.poll() is None

    def view(self, order: ViewOrder, patience_s: float) -> View | None:
        """Ask; EOFError or OSError where the process is gone."""
        self._link.send_bytes(json.dumps(order.to_json()).encode())
        if order.shared is not None:
            send_handle(self._link, order.shared.descriptor, self.pid)
        answer = json.loads(self._received(patience_s))
        if "error" in answer:
            raise _error(answer)
        if "same" in answer:
            return None
        return View(SeenFrame(**answer["frame"]), order.form, self._received(patience_s))

    def end(self) -> None:
        self._link.close()
        self._process.kill()  # it has nothing to finish
        self._process.wait()

    def _received(self, patience_s: float) -> bytes:
        if not self._link.poll(patience_s):
            self._process.kill()
            _log.warning("the viewing process did not answer", waited_s=patience_s)
            raise ViewerLost(f"no picture came within {patience_s:g} s; is the disk stuck?")
        return self._link.recv_bytes()


def _error(answer: dict[str, Any]) -> StationError:
    kind = getattr(errors, answer["error"], StationError)
    error: StationError = kind(answer["message"])
    return error
