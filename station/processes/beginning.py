"""What every process of a station does first.

In a module of its own, which loads little: a capture process that is started again while a train
passes must not load the store and the web first.
"""

from pathlib import Path

from station.logs import log_process_as
from station.processes.lock import share
from station.settings import LogLevel


def begin_process(process: str, level: LogLevel, lock: Path) -> None:
    """Log as a process of the station, and be known as one to a station started after this."""
    log_process_as(process, level)
    share(lock)
