"""Copying a store in SQLite as it is at one moment, and checking a copy."""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

from station.errors import InputUnusable, StoreUnusable

MAGIC = b"SQLite format 3\x00"


def copy_store(source: Path, target: Path) -> None:
    """Copy a store that may be in use into a file that needs no other beside it.

    All in one step: a copy in several begins again whenever somebody writes meanwhile, and in WAL
    mode the one step holds up nobody.

    Raises
    ------
    StoreUnusable
        If the store cannot be read, or the disk does not take the copy.
    """
    try:
        with closing(_open(source)) as present, closing(sqlite3.connect(target)) as copy:
            present.backup(copy)
            copy.execute("PRAGMA journal_mode = DELETE")
    except sqlite3.Error as error:
        raise StoreUnusable(f"{source} cannot be copied to {target} ({error})") from error
    ensure_whole(target)
    flush(target)


def ensure_whole(path: Path) -> None:
    """Check every page of a copy, and that its rows refer to each other.

    Raises
    ------
    InputUnusable
        If it is damaged.
    """
    try:
        with closing(_open(path)) as copy:
            found = copy.execute("PRAGMA integrity_check(1)").fetchone()[0]
            dangling = copy.execute("PRAGMA foreign_key_check").fetchone()
    except sqlite3.DatabaseError as error:
        found, dangling = str(error), None
    if found != "ok" or dangling is not None:
        why = found if found != "ok" else f"a row of {dangling[0]} refers to none of {dangling[2]}"
        raise InputUnusable(f"{path}: damaged ({' '.join(why.split())}); give another backup")


def revision_in(path: Path) -> str | None:
    """Return the revision of a copy without touching it; None of a file that is none."""
    try:
        uri = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
        with closing(sqlite3.connect(uri, uri=True)) as copy:
            revision: str = copy.execute("SELECT version_num FROM alembic_version").fetchone()[0]
    except (sqlite3.DatabaseError, TypeError):  # a table without a row
        return None
    return revision


def fold_log(path: Path) -> None:
    """Bring what the write-ahead log holds into the file, as far as a damaged one lets it."""
    try:
        with closing(_open(path)) as store:
            store.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    except sqlite3.DatabaseError:
        return  # it is put aside as it is, its log with it


def flush(path: Path) -> None:
    """Have the disk keep a file, and its name in the folder."""
    for each in (path, path.parent):
        descriptor = os.open(each, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _open(path: Path) -> sqlite3.Connection:
    # Never made where it is not there.
    return sqlite3.connect(f"{path.absolute().as_uri()}?mode=rw", uri=True)
