"""The disk and the store: what is used, what makes way next, when there was a backup."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from station.operations import DataLayout, Station
from station.settings import StorageSettings
from station.storage import GB, Candidate, Deletion, due_deletions, next_to_go, recordings_bytes

_SHOWN: Final = 8


@dataclass(frozen=True, slots=True)
class Usage:
    """How full the disk is; None where it cannot be read.

    Attributes
    ----------
    due
        Recordings that make way at the next look.
    next
        Those that would make way first; nothing asks for it now.
    ever
        Whether a setting has measured recordings make way at all.
    """

    total_bytes: int
    free_bytes: int
    recordings_bytes: int
    quota_bytes: int | None
    due: Sequence[Deletion]
    next: Sequence[Candidate]
    ever: bool

    @property
    def used_of_quota(self) -> float | None:
        """Part of the quota that is used, 0 to 1; None where there is no quota."""
        if self.quota_bytes is None:
            return None
        return min(self.recordings_bytes / self.quota_bytes, 1.0)


@dataclass(frozen=True, slots=True)
class LastBackup:
    """The last backup that the station knows of."""

    file: str
    at: datetime


def usage_of(station: Station) -> Usage:
    """Return how full the disk is; every file of a recording is looked at.

    Raises
    ------
    OSError
        If the disk cannot be read.
    """
    storage, root = station.settings.storage, station.layout.root
    disk = shutil.disk_usage(root)
    due = due_deletions(station.store, root, storage, station.now())
    gone = {each.candidate.recording_id for each in due}
    following = next_to_go(station.store, root, most=_SHOWN + len(gone))
    return Usage(
        total_bytes=disk.total,
        free_bytes=disk.free,
        recordings_bytes=recordings_bytes(root),
        quota_bytes=_quota_bytes(storage),
        due=due,
        next=[each for each in following if each.recording_id not in gone][:_SHOWN],
        ever=storage.quota_gb is not None or storage.keep_days is not None,
    )


def _quota_bytes(storage: StorageSettings) -> int | None:
    return None if storage.quota_gb is None else round(storage.quota_gb * GB)


def last_backup(layout: DataLayout) -> LastBackup | None:
    """Return the last backup; None where none was noted."""
    note = layout.backup_note
    try:
        at = datetime.fromtimestamp(note.stat().st_mtime, UTC)
        return LastBackup(Path(note.read_text("utf-8").strip()).name, at)
    except (OSError, UnicodeDecodeError):
        return None
