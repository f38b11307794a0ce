"""Handing out the files of a recording: by its name and a number, never by a path."""

from pathlib import Path

from station.errors import NotFound, StateConflict
from station.operations.collaborators import Station
from station.storage import files_of_recording
from station.store import Recording, the


def recording_file(station: Station, recording_id: str, number: int) -> Path:
    """Return the file of that number, from 1, of a recording.

    Raises
    ------
    NotFound
        If the station knows no such recording, or it has no such file.
    StateConflict
        If it is still being written, or was deleted.
    """
    files = recording_files(station, recording_id)
    if not (1 <= number <= len(files)):
        raise NotFound(
            f"recording {recording_id} has {len(files)} files; there is no file {number}"
        )
    return files[number - 1]


def recording_files(station: Station, recording_id: str) -> list[Path]:
    """Return the files of a recording, in order; `recording_file` says what it raises.

    None where they are not on the disk.
    """
    with station.store.look() as session:
        row = the(session, Recording, recording_id)
    if row.closed_at is None:
        raise StateConflict(
            f"recording {row.id} still runs; finish it, then fetch it", state="recording"
        )
    if row.deleted_at is not None:
        raise StateConflict(
            f"recording {row.id} was deleted on {row.deleted_at:%Y-%m-%d}", state="deleted"
        )
    return files_of_recording(station.layout.root / row.path)
