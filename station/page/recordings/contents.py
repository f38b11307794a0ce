"""What the files of a recording say: settings of the camera, names, attachments, event times."""

from dataclasses import dataclass
from datetime import datetime

from station.errors import InputUnusable, RecordingUnreadable
from station.operations import Station, recording_file
from station.recording import Event, RecordingInfo, info
from station.viewing import moment


@dataclass(frozen=True, slots=True)
class Contents:
    """What a recording's file says, or why it says nothing."""

    found: RecordingInfo | None
    refused: str | None


def contents(station: Station, recording_id: str) -> Contents:
    """Return what the first file of a closed recording says, without reading its pictures.

    Raises
    ------
    NotFound
        If there is no such recording, or no file of it.
    StateConflict
        If it is still being written, or was deleted.
    """
    path = recording_file(station, recording_id, 1)
    try:
        return Contents(info(path), None)
    except (InputUnusable, RecordingUnreadable) as error:
        # Where the station keeps its files is nobody's business.
        return Contents(None, str(error).replace(str(path), "its first file"))


def moment_of(event: Event) -> datetime:
    """Return when an event happened, UTC."""
    return datetime.fromisoformat(moment(event.time_ns))
