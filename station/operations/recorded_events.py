"""Listing what happened while a recording was made."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from station.operations.collaborators import Station
from station.operations.frames import in_files
from station.recording import Event, events


@dataclass(frozen=True, slots=True)
class ListedEvent:
    """An event of a recording."""

    number: int
    """Its place among the events of the recording, from 1."""
    event: Event


def events_page(
    station: Station, recording_id: str, *, after: int, limit: int
) -> tuple[list[ListedEvent], bool]:
    """Return events of a recording behind the number `after`, and whether more follow.

    Raises
    ------
    NotFound
        If the station knows no such recording, or none of its files is there.
    StateConflict
        If it is still being written, or was deleted.
    RecordingUnreadable
        If a file is damaged.
    """

    def listed(files: Sequence[Path]) -> list[ListedEvent]:
        numbered = enumerate(_events(files), start=1)
        return [ListedEvent(*each) for each in islice(numbered, after, after + limit + 1)]

    found = in_files(station, recording_id, listed)
    return found[:limit], len(found) > limit


def _events(files: Sequence[Path]) -> Iterator[Event]:
    for path in files:
        yield from events(path)
