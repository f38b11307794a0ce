"""A process beside the API that is started when it is needed, and ends when nobody asks it.

What takes long, or loads much, is done there: in the API's own it would hold up every call.
"""

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import cast

from station.processes.beginning import begin_process
from station.processes.one_core import use_one_core
from station.processes.priority import yield_to_others
from station.settings import LogLevel


class ProcessOnCall:
    """The asking end; whoever uses it takes turns.

    Parameters
    ----------
    module
        What the process runs; it calls `answer_calls`.
    level
        What the process logs.
    lock
        The file of whose lock every process of the station holds a share.
    idle_s
        The process ends by itself when nobody has asked it for so long.
    """

    def __init__(self, module: str, level: LogLevel, lock: Path, idle_s: float) -> None:
        self._module = module
        self._arguments = (str(idle_s), level, str(lock))
        self._running: tuple[subprocess.Popen[bytes], Connection] | None = None

    @property
    def pid(self) -> int | None:
        """Process id; None where there is no such process."""
        running = self._running
        if running is None or running[0].poll() is not None:
            return None
        return running[0].pid

    def link(self) -> Connection:
        """Return the link to the process, which is started where there is none.

        Using it raises EOFError or OSError where the process has gone; `end` it then.
        """
        if self.pid is None:
            self.end()
            self._running = self._started()
        return cast(tuple[object, Connection], self._running)[1]

    def end(self) -> None:
        """End the process: it has nothing to finish; the next `link` starts another."""
        if self._running is not None:
            process, link = self._running
            link.close()
            process.kill()
            process.wait()
        self._running = None

    def _started(self) -> tuple[subprocess.Popen[bytes], Connection]:
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-m", self._module, str(theirs.fileno()), *self._arguments]
        process = subprocess.Popen(  # noqa: S603  our own code
            command, pass_fds=(theirs.fileno(),), stdin=subprocess.DEVNULL
        )
        theirs.close()
        # One that ends by itself is buried at once, not when it is asked the next time.
        threading.Thread(target=process.wait, name=f"{self._module} ended", daemon=True).start()
        return process, Connection(ours.detach())


def answer_calls(name: str, serve: Callable[[Connection, float], None]) -> None:
    """Be the process: `serve` the link for as long as somebody asks, at most so many s apart.

    A service manager's TERM ends it where it is, and Ctrl-C at a terminal is for the process that
    answers calls, whose end closes the link.
    """
    descriptor, idle_s, level, lock = sys.argv[1:5]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield_to_others()
    use_one_core()
    begin_process(name, cast(LogLevel, level), Path(lock))
    serve(Connection(int(descriptor)), float(idle_s))
