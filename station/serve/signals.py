"""Being told to stop, also while waiting for something else."""

import os
import signal
from types import FrameType

_STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)


class StopSignal:
    """SIGTERM and SIGINT as something that can be waited for together with other things."""

    def __init__(self) -> None:
        self.received = False
        # The first end becomes readable with the signal.
        self.readable, self._writable = os.pipe()
        os.set_blocking(self._writable, False)
        for number in _STOP_SIGNALS:
            signal.signal(number, self._note)

    def _note(self, _number: int, _frame: FrameType | None) -> None:
        self.received = True
        os.write(self._writable, b"s")
