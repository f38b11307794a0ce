"""Orders to the capture process over a Unix socket: a line of JSON each way."""

import contextlib
import json
import selectors
import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from station.errors import InputUnusable, StationError

_PIECE_BYTES = 1 << 16

Answer = Callable[[dict[str, Any]], None]
"""Takes the answer to an order, now or later."""


def refusal(error: StationError) -> dict[str, Any]:
    """Return the answer that raises the error at the caller's."""
    state = getattr(error, "state", None)
    return {"error": type(error).__name__, "message": str(error), "state": state}


@dataclass(slots=True, eq=False)
class Caller:
    """One connection; its next order is read once the last was answered."""

    connection: socket.socket
    received: bytearray = field(default_factory=bytearray)

    def answer(self, fields: dict[str, Any], *descriptors: int) -> None:
        """Answer the order, and share open files; a caller that has gone does not mind."""
        line = json.dumps(fields).encode() + b"\n"
        with contextlib.suppress(OSError):
            sent = socket.send_fds(self.connection, [line], descriptors)
            self.connection.sendall(line[sent:])

    def next_order(self) -> dict[str, Any] | None:
        """Return the next whole order; ValueError or TypeError where it is none."""
        line, end, rest = self.received.partition(b"\n")
        if not end:
            return None
        self.received = rest
        order = json.loads(line)
        if not isinstance(order, dict):
            raise TypeError("an order is a JSON object")
        return order


class ControlServer:
    """Listens at a path; the capture process asks it for orders between frames."""

    def __init__(self, path: Path) -> None:
        self._path = path
        path.unlink(missing_ok=True)  # of a capture process that was killed
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._listener.bind(str(path))
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputUnusable(f"{path}: no socket can be made there ({reason})") from error
        path.chmod(0o600)
        self._listener.listen()
        self._listener.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)

    def orders(self, timeout_s: float) -> list[tuple[Caller, dict[str, Any]]]:
        """Return the orders that have come; wait for the first so long at most."""
        found = []
        ready = self._selector.select(timeout_s)
        if any(key.data is None for key, _ in ready):
            self._accept()
            # Its order has mostly come with it, and the next look is a frame away.
            ready = [each for each in self._selector.select(0.0) if each[0].data is not None]
        for key, _ in ready:
            caller: Caller = key.data
            if not self._read(caller):
                self._forget(caller)
                continue
            try:
                order = caller.next_order()
            except (TypeError, ValueError) as error:
                caller.answer(refusal(InputUnusable(f"not an order: {error}")))
                self._forget(caller)
                continue
            if order is not None:
                found.append((caller, order))
        return found

    def close(self) -> None:
        """Hear no more, and take the socket's name away."""
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]  # only sockets are registered
        self._selector.close()
        self._path.unlink(missing_ok=True)

    def _accept(self) -> None:
        connection, _ = self._listener.accept()
        self._selector.register(connection, selectors.EVENT_READ, Caller(connection))

    def _read(self, caller: Caller) -> bool:
        try:
            piece = caller.connection.recv(_PIECE_BYTES)
        except OSError:
            return False
        caller.received += piece
        return bool(piece)

    def _forget(self, caller: Caller) -> None:
        self._selector.unregister(caller.connection)
        caller.connection.close()
