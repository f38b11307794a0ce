"""Backups one after the other in a folder: named by their moment, the oldest of many given up."""

from datetime import UTC, datetime
from pathlib import Path

from station.backups.checksums import beside

_FORM = "store-%Y%m%dT%H%M%SZ.backup"
_PATTERN = "store-????????T??????Z.backup"


def next_in(folder: Path, at: datetime) -> Path:
    """Return the name of a backup made at a moment."""
    return folder / at.astimezone(UTC).strftime(_FORM)


def drop_all_but(folder: Path, newest: int) -> list[Path]:
    """Delete the backups of a folder but so many of the newest; return those deleted.

    Only what `next_in` named is looked at: other files of the folder are somebody's.

    Raises
    ------
    OSError
        If one cannot be deleted.
    """
    old = sorted(folder.glob(_PATTERN), reverse=True)[newest:]
    for path in old:
        # The checksum first: a backup without one is still a backup, the reverse is rubbish.
        beside(path).unlink(missing_ok=True)
        path.unlink()
    return old
