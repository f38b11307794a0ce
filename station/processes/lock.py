"""A lock in a file: one holder at a time, gone with its process however that ends."""

import fcntl
import os
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

from station.errors import StateConflict

_PATIENCE_S = 2.0
_PAUSE_S = 0.05


@contextmanager
def held(
    path: Path,
    what: str,
    sleep: Callable[[float], None] = time.sleep,
    *,
    patience_s: float = _PATIENCE_S,
) -> Generator[None, None, None]:
    """Hold the lock while the block runs.

    Raises
    ------
    StateConflict
        If another process holds it for `patience_s`; a look by `is_held` lasts microseconds.
    """
    with path.open("a") as stream:
        for attempt in range(int(patience_s / _PAUSE_S), -1, -1):
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if attempt == 0:
                    raise StateConflict(f"{what} runs already on {path.parent}; stop it") from None
                sleep(_PAUSE_S)
        yield


def share(path: Path) -> None:
    """Hold a share of the lock until this process ends, however it ends.

    Shares keep `held` waiting, and not each other.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_CREAT | os.O_CLOEXEC, 0o644)
    fcntl.flock(descriptor, fcntl.LOCK_SH)


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
