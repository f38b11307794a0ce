"""The files of one recording: NAME.mcap, and those it goes on in, NAME.0002.mcap and so on.

Each file says in its metadata where it goes on and where it comes from.  A file whose writer died
says only the second; names and that together join them again.
"""

import os
from collections.abc import Sequence
from pathlib import Path

from station.errors import RecordingUnreadable
from station.recording.activefile import active_path
from station.recording.opening import open_recording
from station.recording.reader import metadata_of

SESSION = "session"
ACCOUNTING = "accounting"
PART = "part"
CONTINUED_FROM = "continued_from"
CONTINUED_IN = "continued_in"
_DIGITS = 4


def part_path(path: Path, number: int) -> Path:
    """Return where the recording `path` has its part of that number, from 1.

    Examples
    --------
    >>> part_path(Path("left.mcap"), 1).name, part_path(Path("left.mcap"), 2).name
    ('left.mcap', 'left.0002.mcap')
    """
    if number == 1:
        return path
    return path.with_name(f"{path.stem}.{number:0{_DIGITS}}{path.suffix}")


def parts_of(path: Path) -> tuple[Path, ...]:
    """Return the files of a recording from `path` on, in order; most recordings have one.

    Raises
    ------
    InputUnusable
        If there is no such file.
    RecordingUnreadable
        If a file is no whole recording, or one that it goes on in is missing.
    """
    found = [path]
    said = _said(path)
    first = _first_of(path, said)
    while (following := _following(found[-1], first, said)) is not None:
        found.append(following)
        said = _said(following)
    return tuple(found)


def whole_recordings(sources: Sequence[Path]) -> list[tuple[Path, ...]]:
    """Return the files of each of the recordings, those that belong together once.

    A shell's ``left*.mcap`` names the later files of a recording too, and before the first one.
    """
    groups = [parts_of(source) for source in sources]
    later = {_real(part) for group in groups for part in group[1:]}
    return [group for group in groups if _real(group[0]) not in later]


def left_behind(path: Path) -> list[tuple[int, Path]]:
    """Return (number, path of the part to be) of what a writer left of a recording, in order."""
    found: list[tuple[int, Path]] = []
    while (part := part_path(path, len(found) + 1)).exists() or active_path(part).exists():
        found.append((len(found) + 1, part))
    return found


def _said(path: Path) -> dict[str, dict[str, str]]:
    with open_recording(path) as recording:
        return metadata_of(recording)


def _first_of(path: Path, said: dict[str, dict[str, str]]) -> tuple[Path, int]:
    """Return the name of the first part, and the number of this one."""
    number = _number(said)
    stem = path.stem
    if number > 1 and stem.endswith(f".{number:0{_DIGITS}}"):
        stem = stem[: -_DIGITS - 1]
    return path.with_name(f"{stem}{path.suffix}"), number


def _following(part: Path, place: tuple[Path, int], said: dict[str, dict[str, str]]) -> Path | None:
    """Return the file that a part goes on in, or None where it is the last one."""
    first, number = place
    number = max(number, _number(said))
    ends_here = ACCOUNTING in said and CONTINUED_IN not in said[ACCOUNTING]
    by_name = part_path(first, number + 1)
    if ends_here:
        # Or so its process had thought, which was told to end: another may have gone on since.
        return by_name if by_name.exists() and _goes_on(said, by_name, number) else None
    named = part.with_name(said.get(ACCOUNTING, {}).get(CONTINUED_IN, by_name.name))
    for candidate in (named, by_name):
        if candidate.exists() and _goes_on(said, candidate, number):
            return candidate
    if active_path(named).exists():
        raise RecordingUnreadable(
            f"{part} goes on in {named.name}, which is unfinished; "
            f"`station recording recover {active_path(named)}` makes it whole"
        )
    if ACCOUNTING in said:
        raise RecordingUnreadable(
            f"{part} goes on in {named.name}, which is not there; put it beside, the parts of a "
            "recording belong together"
        )
    return None


def _number(said: dict[str, dict[str, str]]) -> int:
    text = said.get(SESSION, {}).get(PART, "1")
    return int(text) if text.isdecimal() else 1  # damaged: reading the file will tell


def _goes_on(said: dict[str, dict[str, str]], candidate: Path, number: int) -> bool:
    """Whether a file is the part after `number` of the same session."""
    session = _said(candidate).get(SESSION, {})
    same = session.get("id") == said.get(SESSION, {}).get("id")
    return same and session.get(PART) == str(number + 1)


def _real(path: Path) -> str:
    return os.path.realpath(path)
