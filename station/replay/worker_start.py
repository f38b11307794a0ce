"""What a worker of this machine does when it starts: Dask imports this by its name."""

import os
import signal
from typing import Any

from station.processes.lifeline import end_with_parent


def dask_setup(_worker: Any) -> None:
    """End with the process that replays, and leave a terminal's Ctrl-C to it."""
    end_with_parent(os.getppid(), signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
