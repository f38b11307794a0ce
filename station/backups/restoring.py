"""Bringing a backup back in the place of the store, which is kept aside."""

import os
import shutil
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from station.backups import postgresql_dumps, sqlite_files
from station.backups.checksums import ensure_checksum
from station.errors import InputUnusable, StoreUnusable
from station.operations import DataLayout
from station.store import (
    Action,
    Actor,
    Store,
    audit,
    ensure_known,
    file_of,
    migrate,
    revision_of,
    sqlite_url,
)
from station.worker import held

_LOGS = ("-wal", "-shm")


@dataclass(frozen=True, slots=True)
class Restored:
    """What came of bringing a backup back."""

    revision: str
    """Of the backup; the store is at the newest now."""
    aside: Path | None
    """Where what was there before is kept; None where there was nothing."""


def restore_backup(layout: DataLayout, backup: Path, *, by: Actor, at: datetime) -> Restored:
    """Put a backup in the place of a station's store.

    What was there is kept in a folder beside it.  Interrupted at any moment, the store is the one
    or the other.  Recordings stay where they are; those made since the backup are no longer known.

    Raises
    ------
    StateConflict
        If the station runs, or processes of one that was killed are still ending.
    InputUnusable
        If it is no whole backup, or one of the other kind of database.
    StoreUnusable
        If the disk or the database does not take it.
    StoreNewer
        If it is of a newer version of the station.
    """
    digest = ensure_checksum(backup)
    file = file_of(layout.store_url)
    _ensure_kind(backup, file)
    layout.ensure()
    killed = held(layout.processes_lock, "a process of a killed station")
    with held(layout.station_lock, "a station"), killed:
        aside = (layout.root if file is None else file.parent) / f"replaced-{at:%Y%m%dT%H%M%SZ}"
        if aside.exists():
            raise InputUnusable(f"{aside}: is there already; try again in a second")
        try:
            if file is not None:
                revision = _replace_file(layout, file, backup, aside)
            else:
                revision = _replace_database(layout, backup, aside)
        except OSError as error:
            raise StoreUnusable(
                f"{error.filename}: {error.strerror}; {backup} stays good"
            ) from error
        migrate(layout.store_url)
        _note(layout.store_url, backup, digest, by, at)
    return Restored(revision, aside if aside.exists() else None)


def _ensure_kind(backup: Path, file: Path | None) -> None:
    with backup.open("rb") as stream:
        began = stream.read(len(sqlite_files.MAGIC))
    kinds = {"SQLite": sqlite_files.MAGIC, "PostgreSQL": postgresql_dumps.MAGIC}
    wanted = "PostgreSQL" if file is None else "SQLite"
    if not began.startswith(kinds[wanted]):
        found = next((kind for kind in kinds if began.startswith(kinds[kind])), "no store")
        raise InputUnusable(f"{backup}: a backup of {found}; the station's store is in {wanted}")


def _replace_file(layout: DataLayout, file: Path, backup: Path, aside: Path) -> str:
    new = file.with_name(f"{file.name}.restoring")
    shutil.copyfile(backup, new)
    try:
        _give_to_owner(new, file.parent)
        sqlite_files.ensure_whole(new)
        revision = _revision(sqlite_url(new), backup)
        sqlite_files.flush(new)
        if file.exists():
            _keep_aside(file, aside)
        # Its rows say which jobs ran; what the engine knows of them is of another past.
        for name in ("", *_LOGS):
            _move(layout.jobs_file.with_name(layout.jobs_file.name + name), aside)
        new.replace(file)
        sqlite_files.flush(file)
    finally:
        new.unlink(missing_ok=True)
    return revision


def _give_to_owner(file: Path, folder: Path) -> None:
    """Let the station's user have what root brings back: the station could not write to it."""
    if os.geteuid() == 0:
        owner = folder.stat()
        os.chown(file, owner.st_uid, owner.st_gid)


def _keep_aside(file: Path, aside: Path) -> None:
    """Give the old file a second name: at no moment is there a station without a store."""
    sqlite_files.fold_log(file)
    aside.mkdir()
    os.link(file, aside / file.name)
    for name in _LOGS:
        _move(file.with_name(file.name + name), aside)


def _move(path: Path, aside: Path) -> None:
    if path.exists():
        aside.mkdir(exist_ok=True)
        shutil.move(path, aside / path.name)  # perhaps to another disk


def _revision(url: str, backup: Path) -> str:
    revision = revision_of(url)
    if revision is None:
        raise InputUnusable(f"{backup}: a database, but no backup of a station")
    ensure_known(revision)
    return revision


def _replace_database(layout: DataLayout, backup: Path, aside: Path) -> str:
    url = layout.store_url
    postgresql_dumps.ensure_readable(url, backup)
    if revision_of(url) is not None:
        aside.mkdir()
        postgresql_dumps.dump_store(url, aside / "station.dump")
    postgresql_dumps.load_dump(url, backup)
    for name in ("", *_LOGS):
        _move(layout.jobs_file.with_name(layout.jobs_file.name + name), aside)
    return _revision(url, backup)


def _note(url: str, backup: Path, digest: str, by: Actor, at: datetime) -> None:
    store = Store.open(url)
    try:
        with store.change() as session:
            after = {"sha256": digest}
            audit(session, Action.RESTORE, "store", backup.name, by=by, at=at, after=after)
    finally:
        store.close()
