"""A lock in a file: one holder at a time, gone with its process however that ends."""

import fcntl
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

from station.errors import StateConflict

_PATIENCE_S = 2.0
_PAUSE_S = 0.05


@contextmanager
def held(
    path: Path, what: str, sleep: Callable[[float], None] = time.sleep
) -> Generator[None, None, None]:
    """Hold the lock while the block runs.

    Raises
    ------
    StateConflict
        If another process holds it for 2 s; a look by `is_held` lasts microseconds.
    """
    with path.open("a") as stream:
        for attempt in range(int(_PATIENCE_S / _PAUSE_S), -1, -1):
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if attempt == 0:
                    raise StateConflict(f"{what} runs already on {path.parent}; stop it") from None
                sleep(_PAUSE_S)
        yield


def is_held(path: Path) -> bool:
    """Tell whether a process holds the lock."""
    if not path.exists():
        return False
    with path.open("a") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False
