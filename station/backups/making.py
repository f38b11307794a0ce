"""Making a backup while the station runs."""

from dataclasses import dataclass
from pathlib import Path

from station.backups import postgresql_dumps, sqlite_files
from station.backups.checksums import beside, write_checksum
from station.errors import InputUnusable
from station.store import file_of, revision_of


@dataclass(frozen=True, slots=True)
class Backup:
    """A backup that was written and checked."""

    path: Path
    size_bytes: int
    sha256: str
    revision: str


def make_backup(url: str, out: Path) -> Backup:
    """Write the store at a URL into a file, and its checksum beside it.

    The file has its name once it is whole: what an interruption leaves is called otherwise.

    Raises
    ------
    InputUnusable
        If there is no store yet, `out` is there already or cannot be written.
    StoreUnusable
        If the database does not let it.
    """
    file = file_of(url)
    revision = revision_of(url)
    if revision is None:
        raise InputUnusable("there is no store yet to back up; has `station serve` run?")
    if out.exists() or beside(out).exists():
        raise InputUnusable(f"{out}: is there already; give another name")
    if not out.parent.is_dir():
        raise InputUnusable(f"{out.parent}: no such folder; give one that is there")
    part = out.with_name(f"{out.name}.part")
    part.unlink(missing_ok=True)
    try:
        if file is not None:
            sqlite_files.copy_store(file, part)
        else:
            postgresql_dumps.dump_store(url, part)
            postgresql_dumps.ensure_readable(url, part)
        size_bytes = part.stat().st_size
        part.rename(out)
        digest = write_checksum(out)
        sqlite_files.flush(beside(out))
    except OSError as error:
        raise InputUnusable(f"{out}: cannot be written ({error.strerror})") from error
    finally:
        part.unlink(missing_ok=True)
    return Backup(out, size_bytes, digest, revision)
