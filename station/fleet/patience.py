"""Connections to PostgreSQL that wait only so long for anything, and no longer once told to stop.

The server's own time-outs do not help against a server that hangs, nor those of TCP: the kernel of
a host whose PostgreSQL stands still, and a proxy that swallows what it takes, acknowledge every
packet.  Only who waits can count the seconds.
"""

import queue
import threading
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic
from typing import Any, Protocol

import psycopg
from sqlalchemy import Engine, event

_LOOK_S = 0.05
"""How often it is looked whether a connection is worth being waited for."""


class Stop(Protocol):
    """Says when to stop."""

    def is_set(self) -> bool: ...


@dataclass(frozen=True, slots=True)
class Patience:
    """How long to wait: for a connection, names looked up and all, and for each answer.

    `stop` ends every waiting; None where nothing does.
    """

    connect_s: float
    answer_s: float
    stop: Stop | None = None

    def ends_at(self, seconds: float) -> "Deadline":
        """Begin to wait for so long."""
        return Deadline(monotonic() + seconds, seconds, self.stop)


@dataclass(frozen=True, slots=True)
class Deadline:
    """The end of a waiting."""

    at_s: float
    waited_s: float
    stop: Stop | None

    def over(self) -> str | None:
        """Return why it is not waited any longer; None where it is."""
        if self.stop is not None and self.stop.is_set():
            return "told to stop while it was waited for"
        if monotonic() > self.at_s:
            return f"no answer within {self.waited_s:g} s"
        return None


class PatientConnection(psycopg.Connection[Any]):
    """A connection that is given up, closed, where an answer does not come."""

    patience: Patience | None = None
    """None while it connects."""

    @classmethod
    def made(cls, patience: Patience, *arguments: Any, **named: Any) -> "PatientConnection":
        """Connect; what is not there in time is let go, and closed should it come yet.

        Raises
        ------
        psycopg.Error
            If there is no connection in time.
        """
        # In a thread: looking a name up cannot be broken off.
        connecting = _Connecting(lambda: cls.connect(*arguments, **named))
        found = connecting.wait(patience.ends_at(patience.connect_s))
        found.patience = patience
        return found

    def wait(self, gen: Any, *arguments: Any, **named: Any) -> Any:
        if self.patience is None:
            return super().wait(gen, *arguments, **named)
        deadline = self.patience.ends_at(self.patience.answer_s)
        return super().wait(self._until(deadline, gen), *arguments, **named)

    def _until(self, deadline: Deadline, gen: Any) -> Generator[Any, Any, Any]:
        """Do what `gen` does; its driver resumes it ten times a second, answer or none."""
        try:
            awaited = next(gen)
            while True:
                ready = yield awaited
                if not ready and (why := deadline.over()) is not None:
                    self.close()  # what the server still makes of it nobody will read
                    raise psycopg.OperationalError(why)
                awaited = gen.send(ready)
        except StopIteration as end:
            return end.value  # noqa: B901  psycopg drives generators that return their result


class _Connecting:
    """A connection that is being made, in a thread of its own, and may come too late."""

    def __init__(self, connect: Callable[[], PatientConnection]) -> None:
        self._connect = connect
        self._made: queue.SimpleQueue[PatientConnection | Exception] = queue.SimpleQueue()
        self._late = threading.Event()
        threading.Thread(target=self._run, name="connecting to the fleet", daemon=True).start()

    def wait(self, deadline: Deadline) -> PatientConnection:
        """Return the connection, as long as it is worth to wait for it."""
        while True:
            try:
                found = self._made.get(timeout=_LOOK_S)
            except queue.Empty:
                if (why := deadline.over()) is not None:
                    self._let_go()
                    raise psycopg.OperationalError(why) from None
                continue
            if isinstance(found, Exception):
                raise found
            return found

    def _run(self) -> None:
        try:
            found = self._connect()
        except Exception as error:  # whatever it is, who waits is told
            self._made.put(error)
            return
        self._made.put(found)
        if self._late.is_set():
            found.close()

    def _let_go(self) -> None:
        """Close what comes too late, and what came at this very moment."""
        self._late.set()
        with suppress(queue.Empty):
            found = self._made.get_nowait()
            if isinstance(found, PatientConnection):
                found.close()


def be_patient(engine: Engine, patience: Patience) -> None:
    """Have an engine of PostgreSQL wait only so long."""

    @event.listens_for(engine, "do_connect")
    def connect(_dialect: Any, _record: Any, arguments: Any, named: Any) -> PatientConnection:
        return PatientConnection.made(patience, *arguments, **named)
