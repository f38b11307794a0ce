"""Tables of the recordings looked into last: who scrubs asks for one frame after the other."""

import os
from collections import OrderedDict
from pathlib import Path

from station.recording import FrameTable, left_behind

_MOST = 4
"""A table of 32,000 frames takes 2 MB, and half a second to read."""
_Mark = tuple[tuple[int, int, int], ...]


class Tables:
    """Remembers the tables of some recordings, as long as their files are the same."""

    def __init__(self) -> None:
        self._kept: OrderedDict[Path, tuple[_Mark, FrameTable]] = OrderedDict()

    def of(self, path: Path) -> FrameTable:
        """Return the table of a recording by its first file; `FrameTable.of` says what it raises.

        One without a file has no frame.
        """
        files = [part for _, part in left_behind(path)]
        mark = tuple(_mark(file) for file in files)
        kept = self._kept.pop(path, None)
        if kept is None or kept[0] != mark:
            kept = mark, FrameTable.of(files)
        self._kept[path] = kept
        if len(self._kept) > _MOST:
            self._kept.popitem(last=False)
        return kept[1]


def _mark(file: Path) -> tuple[int, int, int]:
    """Return what changes when a file is replaced, as compacting does."""
    found = os.stat(file)
    return found.st_ino, found.st_size, found.st_mtime_ns
