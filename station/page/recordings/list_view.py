"""The list of recordings: what each holds, and how it stands."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zoneinfo import ZoneInfo

from station.api import cursor_in, next_of
from station.operations import Station
from station.page.recordings.condition import Condition, condition_of, missing_in
from station.page.recordings.search import Search
from station.storage import files_of_recording
from station.store import Recording
from station.store.recordings_found import recordings_found

_ROWS = 50


@dataclass(frozen=True, slots=True)
class RecordingRow:
    """One recording of the list."""

    row: Recording
    condition: Condition
    missing: int
    size_bytes: int | None
    """None where it has no finished file."""


@dataclass(frozen=True, slots=True)
class RecordingList:
    """A page of the list."""

    rows: tuple[RecordingRow, ...]
    older: str | None
    """Address of the next page; None on the last."""


def recording_list(station: Station, search: Search) -> RecordingList:
    """Return the recordings that are looked for, the newest first.

    Raises
    ------
    InputUnusable
        If the span of days is none, or `before` is not from the address of a page.
    """
    zone = zone_of(station)
    with station.store.look() as session:
        page = recordings_found(
            session, search.wanted(zone), limit=_ROWS, before=cursor_in(search.before or None)
        )
    cursor = next_of(page.rows, lambda row: (row.opened_at, row.id), more=page.more)
    return RecordingList(
        rows=tuple(_row(station, row) for row in page.rows),
        older=None if cursor is None else search.older(cursor),
    )


def zone_of(station: Station) -> ZoneInfo | None:
    """Return the station's zone; None where that is the host's."""
    name = station.settings.time_zone
    return None if name is None else ZoneInfo(name)


def files_on_disk(station: Station, row: Recording) -> Sequence[Path]:
    """Return the finished files of a recording; none of one that was deleted."""
    if row.deleted_at is not None:
        return ()
    return files_of_recording(station.layout.root / row.path)


def _row(station: Station, row: Recording) -> RecordingRow:
    sizes = [file.stat().st_size for file in files_on_disk(station, row)]
    return RecordingRow(
        row=row,
        condition=condition_of(row),
        missing=missing_in(row),
        size_bytes=sum(sizes) if sizes else None,
    )
