"""Listing the frames of a recording, without their pictures."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from station.errors import NotFound, RecordingUnreadable
from station.operations.collaborators import Station
from station.operations.downloads import recording_files
from station.recording import ListedFrame, list_frames

_Found = TypeVar("_Found")


def frames_page(
    station: Station, recording_id: str, *, after: int, limit: int
) -> tuple[list[ListedFrame], bool]:
    """Return frames of a recording behind the number `after`, and whether more follow.

    Raises
    ------
    NotFound
        If the station knows no such recording, or none of its files is there.
    StateConflict
        If it is still being written, or was deleted.
    RecordingUnreadable
        If a file is damaged.
    """

    def listed(files: Sequence[Path]) -> list[ListedFrame]:
        return list_frames(files, after=after, most=limit + 1)

    found = in_files(station, recording_id, listed)
    return found[:limit], len(found) > limit


def in_files(
    station: Station, recording_id: str, look: Callable[[Sequence[Path]], _Found]
) -> _Found:
    """Return what is found in the files of a recording; `frames_page` says what it raises."""
    files = recording_files(station, recording_id)
    if not files:
        raise NotFound(f"recording {recording_id} has no file on the disk")
    try:
        return look(files)
    except RecordingUnreadable as error:
        # Where the station keeps its files is nobody's business.
        said = str(error)
        for number, path in enumerate(files, start=1):
            said = said.replace(str(path), f"file {number} of recording {recording_id}")
        raise RecordingUnreadable(said) from error
