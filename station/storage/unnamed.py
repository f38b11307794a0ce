"""Files of recordings that no row of the store names: never deleted, and never passed over.

A store that was restored from a backup does not know what was recorded since; a disk may have been
put in from another station.
"""

from pathlib import Path

from sqlalchemy import select

from station.recording import ACTIVE, left_behind
from station.storage.tidying import RECORDINGS
from station.store import Recording, Store

_SUFFIX = ".mcap"


def unnamed_recordings(store: Store, root: Path) -> list[Path]:
    """Return the recordings on the disk, finished or not, that no row names, in their order.

    Parameters
    ----------
    root
        The folder of the station's data.
    """
    # Looked for first: one that is begun meanwhile has its row before its file.
    found = [
        path
        for path in sorted((root / RECORDINGS).rglob("*"))
        if path.name.removesuffix(ACTIVE).endswith(_SUFFIX) and path.is_file()
    ]
    with store.look() as session:
        named = {root / path for path in session.scalars(select(Recording.path))}
    candidates = [path for path in found if path.with_name(_whole(path)) not in named]
    if not candidates:
        return []
    # The later files of a recording are named after its first.
    parts = {part for path in named for _, part in left_behind(path)}
    return [path for path in candidates if path.with_name(_whole(path)) not in parts]


def _whole(path: Path) -> str:
    return path.name.removesuffix(ACTIVE)
