"""Being told to stop by a signal, also while waiting for something else."""

import os
import select
import signal
from types import FrameType, TracebackType
from typing import Self

STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)


class StopSignal:
    """Signals that mean stop, as something to wait for, alone or together with other things.

    They are taken from its making on; as a context manager it gives them back at the end.

    A signal comes at any moment and more than once: the kernel tells the children of a killed
    process of its death once for each of its threads.  So the handler takes no lock.  Setting a
    `threading.Event` would wait for ever for the lock that the very code it interrupts holds.
    """

    def __init__(self, numbers: tuple[signal.Signals, ...] = STOP_SIGNALS) -> None:
        self._received = False
        # The first end becomes readable with the signal.
        self.readable, self._writable = os.pipe()
        self._before = {number: signal.signal(number, self._note) for number in numbers}

    def is_set(self) -> bool:
        """Return whether the signal has come."""
        return self._received

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the signal, for so many seconds at most; return whether it has come."""
        select.select([self.readable], [], [], timeout)
        return self._received

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        os.close(self.readable)
        os.close(self._writable)

    def _note(self, _number: int, _frame: FrameType | None) -> None:
        if not self._received:
            self._received = True
            os.write(self._writable, b"s")
