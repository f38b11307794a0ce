"""Stores of the newest schema, copied: the way there by steps takes longer than most tests."""

import functools
import tempfile
from pathlib import Path

from sqlalchemy import make_url

from station.store import migrate, sqlite_url


@functools.cache
def _sqlite_file() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "station.sqlite"
        migrate(sqlite_url(path))
        return path.read_bytes()


def make_store(url: str) -> None:
    """Bring an empty database to the newest schema."""
    address = make_url(url)
    if address.get_backend_name() != "sqlite":
        # Copying a database takes PostgreSQL as long as the way there.
        migrate(url)
        return
    path = Path(address.database)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("xb") as file:
        file.write(_sqlite_file())
