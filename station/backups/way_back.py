"""The backup that leads back from a version of the station whose store this one does not know."""

from pathlib import Path
from typing import Final

from station.backups.sqlite_files import revision_in
from station.errors import StoreNewer
from station.operations import DataLayout
from station.store import ensure_known, file_of

_FOLDER: Final = "backups"
"""Below the data, where the package's upgrade and its timer put them."""


def newest_restorable(layout: DataLayout) -> Path | None:
    """Return the newest backup beside the data that this version can bring back, if one is there.

    Of a store in SQLite alone: what revision a dump of PostgreSQL is of shows as it is loaded.
    """
    if file_of(layout.store_url) is None:
        return None
    found = (layout.root / _FOLDER).glob("*.backup")
    newest_first = sorted(found, key=lambda path: path.stat().st_mtime_ns, reverse=True)
    return next((path for path in newest_first if _is_known(path)), None)


def _is_known(backup: Path) -> bool:
    revision = revision_in(backup)
    if revision is None:
        return False
    try:
        ensure_known(revision)
    except StoreNewer:
        return False
    return True
