"""What a worker of this machine does when it starts: Dask imports this by its name."""

import os
import signal
import tempfile
from typing import Any

from station.processes.lifeline import end_with_parent
from station.processes.priority import yield_to_others, yields


def dask_setup(worker: Any) -> None:
    """End with the process that replays, leave a terminal's Ctrl-C to it, and files to its folder.

    What a killed worker had fetched is removed with that folder.
    """
    end_with_parent(os.getppid(), signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if yields():  # as a station's do: a wheel that passes now goes first
        yield_to_others()
    tempfile.tempdir = str(worker.local_directory)
