"""Compacting what was measured: it is kept for questions, and seldom read."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import structlog

from station.errors import DiskFull, NothingMeasurable, StateConflict, StationError
from station.progress import Progress, silent
from station.recording import CompactReport, compact, is_compact
from station.storage.tidying import files_of_recording
from station.store import Recording, Store, the
from station.store.disposal import measured_recordings

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class CompactedFiles:
    """What became of the files of measured recordings."""

    compacted: tuple[CompactReport, ...]
    left: tuple[str, ...]
    """Why a file stays as it is, a line each."""


def due_for_compacting(store: Store, before: datetime) -> list[str]:
    """Return the recordings that were measured, closed before a moment, and not compacted yet.

    Recordings of calibration sessions stay as they are: calibrations name their SHA-256.
    """
    with store.look() as session:
        rows = measured_recordings(session)
        return [
            row.id
            for row in rows
            if row.compacted_at is None and row.closed_at is not None and row.closed_at <= before
        ]


def compact_recording(
    store: Store, root: Path, recording_id: str, now: datetime, progress: Progress = silent
) -> CompactedFiles:
    """Compact the files of a recording, those that are not yet, and note it in its row.

    Interrupted, it goes on where it was: a file is replaced whole, or not at all.

    Raises
    ------
    DiskFull, StateConflict
        If there is no space beside a file, or somebody works on it: later it may go.
    """
    with store.look() as session:
        files = files_of_recording(root / the(session, Recording, recording_id).path)
    done = _compact(files, progress)
    with store.change() as session:
        the(session, Recording, recording_id).compacted_at = now
    return done


def _compact(files: Sequence[Path], progress: Progress) -> CompactedFiles:
    done: list[CompactReport] = []
    left: list[str] = []
    for place, file in enumerate(files):
        progress(place / len(files), file.name)
        try:
            if not is_compact(file):
                done.append(compact(file))
        except (DiskFull, StateConflict):
            raise
        except NothingMeasurable as error:
            left.append(str(error))
        except StationError as error:
            # One that is damaged must not keep the others from being compacted.
            left.append(str(error))
            _log.warning("recording not compacted", file=str(file), why=str(error))
    return CompactedFiles(tuple(done), tuple(left))
