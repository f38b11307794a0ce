"""Keeping the disk within its limits: the store says what may go, and is told what went."""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path

import structlog
from sqlalchemy.orm import Session

from station.progress import Progress, silent
from station.recording import left_behind
from station.settings import StorageSettings
from station.storage.retention import Candidate, Deletion, Kind, Usage, to_delete
from station.storage.space import free_bytes
from station.store import STATION, Action, Recording, Store, audit, the
from station.store.disposal import disposable_recordings, failed_recordings, uploaded_recordings

RECORDINGS = "recordings"
_OF: Mapping[Kind, Callable[[Session], Sequence[Recording]]] = {
    Kind.MEASURED: disposable_recordings,
    Kind.FAILED: failed_recordings,
    Kind.UPLOADED: uploaded_recordings,
}
_log = structlog.get_logger()


def due_deletions(
    store: Store,
    root: Path,
    settings: StorageSettings,
    now: datetime,
    free_of: Callable[[Path], int] = free_bytes,
) -> list[Deletion]:
    """Return the recordings that are to make way."""
    limits = settings.quota_gb, settings.keep_days
    ages = settings.keep_failed_days, settings.keep_uploads_days
    if {*limits, *ages} == {None}:
        return []
    with store.look() as session:
        candidates = [
            _candidate(root, row, kind) for kind, found in _OF.items() for row in found(session)
        ]
    usage = Usage(recordings_bytes(root), free_of(root))
    return to_delete(candidates, usage, settings, now)


def next_to_go(store: Store, root: Path, *, most: int) -> list[Candidate]:
    """Return the measured recordings that make way first, whatever asks for it; oldest first."""
    with store.look() as session:
        rows = disposable_recordings(session)[:most]
        return [_candidate(root, row, Kind.MEASURED) for row in rows]


def tidy(
    store: Store,
    root: Path,
    settings: StorageSettings,
    now: datetime,
    free_of: Callable[[Path], int] = free_bytes,
    progress: Progress = silent,
) -> list[Deletion]:
    """Delete the recordings that are to make way; return them.

    Each is taken off the disk, then noted in its row, the audit trail and the log.  Interrupted in
    between, the next time finds nothing of it on the disk and notes it then.
    """
    gone = due_deletions(store, root, settings, now, free_of)
    for place, deletion in enumerate(gone):
        progress(place / len(gone), deletion.candidate.recording_id)
        _delete(store, root, deletion, now)
    return gone


def _candidate(root: Path, row: Recording, kind: Kind) -> Candidate:
    files = files_of_recording(root / row.path)
    size_bytes = sum(file.stat().st_size for file in files)
    return Candidate(row.id, row.opened_at, size_bytes, kind)


def files_of_recording(path: Path) -> list[Path]:
    """Return the finished files of a recording by their names; nothing of it is opened."""
    return [part for _, part in left_behind(path) if part.exists()]


def _delete(store: Store, root: Path, deletion: Deletion, now: datetime) -> None:
    candidate = deletion.candidate
    with store.change() as session:
        # Looked at again while nobody else can write: a calibration may have come into force.
        may_go = _OF[candidate.kind](session)
        if candidate.recording_id not in {row.id for row in may_go}:
            return
        row = the(session, Recording, candidate.recording_id)
        # The last one first: what an interruption leaves still begins with its first file.
        for file in reversed(files_of_recording(root / row.path)):
            file.unlink()
        row.deleted_at, row.deleted_why = now, deletion.why
        why = {"why": deletion.why}
        audit(session, Action.DELETE, "recording", row.id, by=STATION, at=now, after=why)
    _log.info(
        "recording deleted",
        recording=candidate.recording_id,
        size_bytes=candidate.size_bytes,
        why=deletion.why,
    )


def recordings_bytes(root: Path) -> int:
    """Return what all recordings take on the disk; every file is looked at."""
    sizes = (_size(file) for file in (root / RECORDINGS).rglob("*"))
    return sum(sizes)


def _size(file: Path) -> int:
    try:
        return file.stat().st_size if file.is_file() else 0
    except FileNotFoundError:  # deleted, or finished under its own name, a moment ago
        return 0
