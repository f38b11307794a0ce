"""Compacting what was measured: it is kept for questions, and seldom read."""

from dataclasses import dataclass
from pathlib import Path

import structlog

from station.errors import NothingMeasurable, StationError
from station.progress import Progress, silent
from station.recording import CompactReport, compact, is_compact
from station.storage.tidying import files_of_recording
from station.store import Store, measured_recordings

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class CompactedFiles:
    """What became of the files of measured recordings."""

    compacted: tuple[CompactReport, ...]
    left: tuple[str, ...]
    """Why a file stays as it is, a line each."""


def compact_measured(store: Store, root: Path, progress: Progress = silent) -> CompactedFiles:
    """Compact the recordings of passes that were measured; those that are compact are passed over.

    Recordings of calibration sessions stay as they are: calibrations name their SHA-256.
    """
    with store.look() as session:
        paths = [root / row.path for row in measured_recordings(session)]
    files = [file for path in paths for file in files_of_recording(path)]
    done: list[CompactReport] = []
    left: list[str] = []
    for place, file in enumerate(files):
        progress(place / len(files), file.name)
        try:
            if not is_compact(file):
                done.append(compact(file))
        except NothingMeasurable as error:
            left.append(str(error))
        except StationError as error:
            # One that is damaged must not keep the others from being compacted.
            left.append(str(error))
            _log.warning("recording not compacted", file=str(file), why=str(error))
    return CompactedFiles(tuple(done), tuple(left))
