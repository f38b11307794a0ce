"""A file being recorded: NAME.active, locked, put on the disk every second, renamed when whole."""

import contextlib
import errno
import fcntl
import os
import threading
from collections.abc import Generator
from pathlib import Path

from station.errors import DiskFull, InputUnusable, RecordingError, StateConflict
from station.recording.appender import NO_SPACE

ACTIVE = ".active"
_SYNC_INTERVAL_S = 1.0


def active_path(path: Path) -> Path:
    """Return where the recording `path` is while it is being written."""
    return path.with_name(path.name + ACTIVE)


class ActiveFile:
    """The open file; its owner writes to `descriptor`."""

    def __init__(self, path: Path, descriptor: int) -> None:
        try:
            lock(descriptor, path)
        except StateConflict:
            os.close(descriptor)
            raise
        self.path = path
        self.descriptor = descriptor
        self._failure: OSError | None = None
        self._stop = threading.Event()
        self._sync = threading.Thread(target=self._sync_often, name="sync", daemon=True)
        self._sync.start()

    @classmethod
    def create(cls, path: Path) -> "ActiveFile":
        """Create the file of a new recording.

        Raises
        ------
        InputUnusable
            If the recording exists, is being written, or its folder does not take it.
        """
        if path.exists():
            raise InputUnusable(f"{path} exists; recordings are not overwritten: choose a new name")
        flags = os.O_CREAT | os.O_EXCL | os.O_RDWR
        try:
            descriptor = os.open(active_path(path), flags, 0o644)
        except FileExistsError:
            raise InputUnusable(
                f"{active_path(path)} exists: {path.name} is being written or was interrupted; "
                "choose a new name, or finish it with `station recording recover`"
            ) from None
        except OSError as error:
            raise _failed(path, error, "created") from error
        return cls(path, descriptor)

    @classmethod
    def reopen(cls, path: Path) -> "ActiveFile":
        """Open the unfinished file of the recording `path` to go on with it."""
        try:
            descriptor = os.open(active_path(path), os.O_RDWR)
        except OSError as error:
            raise _failed(path, error, "opened again") from error
        return cls(path, descriptor)

    @contextlib.contextmanager
    def writing(self) -> Generator[None, None, None]:
        """Turn the system's refusals to write into the station's errors."""
        try:
            if self._failure is not None:
                raise self._failure
            yield
        except OSError as error:
            raise _failed(self.path, error, "written") from error

    def ensure_space(self, needed_bytes: int) -> None:
        """Raise what the system does of a full disk where less than that is left for this user."""
        disk = os.fstatvfs(self.descriptor)
        if disk.f_bavail * disk.f_frsize < needed_bytes:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def publish(self) -> None:
        """Put everything on the disk, close, and give the file its name."""
        self.stop_syncing()
        with self.writing():
            try:
                os.fsync(self.descriptor)
            finally:
                os.close(self.descriptor)  # the lock goes with it
            active_path(self.path).rename(self.path)
            sync_folder(self.path.parent)

    def abandon(self) -> None:
        """Close the file as it is, unfinished."""
        self.stop_syncing()
        os.close(self.descriptor)

    def stop_syncing(self) -> None:
        """End the thread that puts the data on the disk."""
        self._stop.set()
        self._sync.join()

    def _sync_often(self) -> None:
        """Call fdatasync off the writer's path; it can take longer than a frame does."""
        while not self._stop.wait(_SYNC_INTERVAL_S):
            try:
                os.fdatasync(self.descriptor)
            except OSError as error:
                self._failure = error
                return


def lock(descriptor: int, path: Path) -> None:
    """Lock an unfinished file, or refuse with StateConflict where another process writes it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise StateConflict(
            f"{path} is being written by another process; wait until it has finished"
        ) from None


def sync_folder(folder: Path) -> None:
    """Put a folder's names on the disk."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _failed(path: Path, error: OSError, verb: str) -> RecordingError | InputUnusable:
    if error.errno in NO_SPACE:
        return DiskFull(f"{path}: no space left in {path.parent}; free some and record again")
    reason = error.strerror or str(error)
    if verb == "created":
        return InputUnusable(f"{path} cannot be created ({reason}); name a folder that takes files")
    return RecordingError(f"{path} cannot be {verb}: {reason}")
