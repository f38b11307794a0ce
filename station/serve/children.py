"""The processes under the supervisor: started, watched, started again, ended in order."""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import structlog

_FIRST_PAUSE_S = 0.2
_LONGEST_PAUSE_S = 10.0
_STEADY_AFTER_S = 30.0
_log = structlog.get_logger()


class Handle(Protocol):
    """A running process, as `multiprocessing` shows it."""

    @property
    def pid(self) -> int | None: ...

    @property
    def exitcode(self) -> int | None: ...

    def terminate(self) -> None: ...

    def kill(self) -> None: ...

    def join(self, timeout: float | None = None) -> None: ...


@dataclass(slots=True)
class Child:
    """One process that is to run as long as the station does.

    One that ends is started again after a pause, which grows while it keeps on ending and is
    short again once it has run for half a minute.
    """

    name: str
    spawn: Callable[[], Handle]
    patience_s: float
    """How long it may take to end when asked."""
    clock: Callable[[], float] = time.monotonic
    handle: Handle | None = field(default=None, init=False)
    restarts: int = field(default=0, init=False)
    pidfd: int | None = field(default=None, init=False)
    """Becomes readable when the process ends."""
    _pause_s: float = field(default=_FIRST_PAUSE_S, init=False)
    _changed_s: float = field(default=0.0, init=False)

    def start(self) -> None:
        """Start the process."""
        self.handle = self.spawn()
        self.pidfd = None if self.handle.pid is None else os.pidfd_open(self.handle.pid)
        self._changed_s = self.clock()
        _log.info("started", child=self.name, pid=self.handle.pid)

    def due_s(self) -> float | None:
        """Return in how many seconds to start it again; None where it runs."""
        if self.handle is not None:
            return None
        return max(self._changed_s + self._pause_s - self.clock(), 0.0)

    def mend(self) -> None:
        """Notice that the process has ended, and start it again when its pause is over."""
        if self.handle is not None:
            if self.handle.exitcode is not None:
                self._note_end(self.handle.exitcode)
        elif self.due_s() == 0.0:
            self.restarts += 1
            self.start()

    def _note_end(self, exitcode: int) -> None:
        ran_s = self.clock() - self._changed_s
        steady = ran_s >= _STEADY_AFTER_S
        self._pause_s = _FIRST_PAUSE_S if steady else min(2 * self._pause_s, _LONGEST_PAUSE_S)
        self._changed_s = self.clock()
        self._forget()
        _log.error("ended", child=self.name, exitcode=exitcode, again_in_s=self._pause_s)

    def ask_to_end(self) -> None:
        """Ask the process to end; it may take its patience."""
        if self.handle is not None:
            self.handle.terminate()

    def ensure_ended(self) -> None:
        """Wait until the process has ended; end it by force when its patience is over."""
        if self.handle is None:
            return
        self.handle.join(self.patience_s)
        if self.handle.exitcode is None:
            _log.error("ended by force", child=self.name, after_s=self.patience_s)
            self.handle.kill()
            self.handle.join()
        _log.info("stopped", child=self.name, exitcode=self.handle.exitcode)
        self._forget()

    def _forget(self) -> None:
        self.handle = None
        if self.pidfd is not None:
            os.close(self.pidfd)
            self.pidfd = None
