"""What a station that was killed leaves behind: processes that are still ending, its sockets.

Its processes are told by the kernel and end in order, which takes a recording's last frames or a
step of a job.  Until then they hold the port, the cameras and the engine of the jobs.
"""

import os
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

import structlog

from station.operations import DataLayout
from station.worker import held

_PATIENCE_S = 60.0
_PREFIX = "treadline-"
_log = structlog.get_logger()


def await_end_of_killed(layout: DataLayout, sleep: Callable[[float], None] = time.sleep) -> None:
    """Wait until no process of an earlier station works on this data folder.

    Raises
    ------
    StateConflict
        If one does not end within a minute.
    """
    waited_s = 0.0

    def wait(seconds: float) -> None:
        nonlocal waited_s
        if not waited_s:
            _log.warning("waiting for the processes of a station that was killed")
        waited_s += seconds
        sleep(seconds)

    what = "a process of a killed station"
    with held(layout.processes_lock, what, wait, patience_s=_PATIENCE_S):
        if waited_s:
            _log.info("they have ended", after_s=round(waited_s, 1))


@contextmanager
def folder_of_sockets(layout: DataLayout) -> Generator[Path]:
    """Keep a folder for sockets while the block runs; that of a killed station is removed first.

    It is in the temporary folder: the path of a Unix socket may have 107 bytes only.
    """
    note = layout.sockets_note
    _remove_left_behind(note)
    folder = Path(tempfile.gettempdir(), _PREFIX + secrets.token_hex(4))
    # Noted before it is made: killed in between, the next start finds nothing to remove.
    note.write_text(str(folder), encoding="utf-8")
    folder.mkdir(mode=0o700)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        note.unlink(missing_ok=True)


def _remove_left_behind(note: Path) -> None:
    if not note.exists():
        return
    folder = Path(note.read_text(encoding="utf-8"))
    ours = folder.is_dir() and folder.stat().st_uid == os.getuid()
    if ours and folder.name.startswith(_PREFIX):
        shutil.rmtree(folder, ignore_errors=True)  # which does not follow a link
