"""Shows that a backup made while others write is one moment of the store, that it is refused when
damaged, and that what a restore replaces is kept, on both databases."""

import errno
import fcntl
import os
import re
import sqlite3
import threading
from datetime import UTC, datetime

import pytest
from newest_schema import make_store
from sqlalchemy import text

from station.backups import make_backup, restore_backup
from station.backups.checksums import write_checksum
from station.errors import InputUnusable, StateConflict, StationError, StoreUnusable
from station.operations import DataLayout
from station.store import Actor, Pass, PassState, Store, migrate
from station.store.connecting import open_engine
from station.store.lists import audit_page
from station.store.watched import counts_by_state
from station.worker import held

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
SOMEBODY = Actor("somebody at the command line")


@pytest.fixture
def layout(any_url, tmp_path):
    root = tmp_path / "data"
    root.mkdir()
    layout = DataLayout(root, None if any_url.startswith("sqlite") else any_url)
    make_store(layout.store_url)
    return layout


def add_passes(layout, *names):
    store = Store.open(layout.store_url)
    for name in names:
        with store.change() as session:
            session.add(Pass(id=name, state=PassState.DONE, opened_at=NOON))
    store.close()


def passes_in(layout):
    store = Store.open(layout.store_url)
    with store.look() as session:
        found = counts_by_state(session, Pass).get("done", 0)
    store.close()
    return found


def restore(layout, path):
    return restore_backup(layout, path, by=SOMEBODY, at=NOON)


def test_a_restored_store_is_that_of_the_backup_and_the_other_is_kept(layout, tmp_path):
    add_passes(layout, "p1")
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p2", "p3")
    assert passes_in(layout) == 3
    layout.jobs_file.write_bytes(b"what the engine knows of jobs that are no more")
    done = restore(layout, made.path)
    assert passes_in(layout) == 1
    assert done.revision == made.revision
    kept = {path.name for path in done.aside.iterdir()}
    assert kept in ({"station.sqlite", "jobs.sqlite"}, {"station.dump", "jobs.sqlite"})
    assert not layout.jobs_file.exists()
    # Kept means usable: the other is brought back in the same way.
    if layout.database is None:
        other = sqlite3.connect(done.aside / "station.sqlite")
        assert other.execute("SELECT count(*) FROM passes").fetchone() == (3,)
        other.close()


def test_a_restore_is_in_the_audit_trail_of_what_it_restored(layout, tmp_path):
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    restore(layout, made.path)
    store = Store.open(layout.store_url)
    with store.look() as session:
        (entry,) = audit_page(session, limit=9).rows
    store.close()
    assert (entry.action, entry.who, entry.subject) == ("restore", SOMEBODY.name, "one.backup")
    assert entry.after == {"sha256": made.sha256}


def test_a_backup_made_while_somebody_writes_holds_whole_transactions(layout, tmp_path):
    stop = threading.Event()

    def write():
        store, n = Store.open(layout.store_url), 0
        while not stop.is_set():
            n += 1
            with store.change() as session:
                for half in "ab":
                    session.add(Pass(id=f"p{n}{half}", state=PassState.DONE, opened_at=NOON))
                    session.flush()
        store.close()

    writer = threading.Thread(target=write)
    writer.start()
    try:
        while passes_in(layout) < 10:
            pass
        made = make_backup(layout.store_url, tmp_path / "one.backup")
    finally:
        stop.set()
        writer.join()
    restore(layout, made.path)
    found = passes_in(layout)
    assert found >= 10
    assert found % 2 == 0


@pytest.mark.usefixtures("once")
def test_a_backup_is_not_restored_while_the_station_runs(layout, tmp_path):
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    with held(layout.station_lock, "a station"), pytest.raises(StateConflict, match="stop it"):
        restore(layout, made.path)
    assert passes_in(layout) == 1


@pytest.mark.usefixtures("once")
def test_a_backup_is_not_restored_while_processes_of_a_killed_station_are_ending(layout, tmp_path):
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    with layout.processes_lock.open("a") as ending:
        fcntl.flock(ending, fcntl.LOCK_SH)
        with pytest.raises(StateConflict, match="killed"):
            restore(layout, made.path)
    assert passes_in(layout) == 1


def flip_a_byte(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def cut(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) * 2 // 3])


@pytest.mark.parametrize("damage", [flip_a_byte, cut])
def test_a_backup_that_changed_since_it_was_written_is_refused(layout, tmp_path, damage):
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    damage(made.path)
    with pytest.raises(InputUnusable, match="changed since it was written"):
        restore(layout, made.path)
    assert passes_in(layout) == 1


def test_a_damaged_backup_with_a_checksum_that_fits_is_refused_too(layout, tmp_path):
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    cut(made.path)
    checksum = made.path.with_name("one.backup.sha256")
    checksum.unlink()
    write_checksum(made.path)
    with pytest.raises(StationError):
        restore(layout, made.path)
    assert passes_in(layout) == 1
    assert not list(layout.root.glob("*.restoring"))


def test_a_backup_does_not_overwrite(layout, tmp_path):
    make_backup(layout.store_url, tmp_path / "one.backup")
    with pytest.raises(InputUnusable, match="is there already"):
        make_backup(layout.store_url, tmp_path / "one.backup")
    with pytest.raises(InputUnusable, match="nowhere: no such folder"):
        make_backup(layout.store_url, tmp_path / "nowhere" / "one.backup")
    assert [path.name for path in tmp_path.glob("*.part")] == []


def test_what_is_no_backup_of_this_station_is_refused_by_name(layout, tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a backup")
    with pytest.raises(InputUnusable, match=re.escape("notes.txt.sha256: cannot be read")):
        restore(layout, text)
    write_checksum(text)
    with pytest.raises(InputUnusable, match="a backup of no store"):
        restore(layout, text)


def test_a_station_that_never_ran_has_nothing_to_back_up(tmp_path):
    layout = DataLayout(tmp_path)
    with pytest.raises(InputUnusable, match="no store yet"):
        make_backup(layout.store_url, tmp_path / "one.backup")
    assert not layout.store_file.exists()


def test_a_disk_that_is_full_leaves_the_store_as_it_was(layout, tmp_path, monkeypatch):
    import station.backups.restoring as restoring  # noqa: PLC0415  beside its only use

    def refuse(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "station.sqlite.restoring")

    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    monkeypatch.setattr(restoring.shutil, "copyfile", refuse)
    monkeypatch.setattr(restoring.postgresql_dumps, "load_dump", refuse)
    with pytest.raises(StoreUnusable, match="No space left on device"):
        restore(layout, made.path)
    assert passes_in(layout) == 1


@pytest.mark.parametrize("any_url", ["postgresql"], indirect=True)
def test_a_database_whose_schema_was_made_anew_is_restored_too(layout, tmp_path):
    engine = open_engine(layout.store_url)
    with engine.begin() as connection:
        connection.execute(text("DROP SCHEMA public CASCADE"))
        connection.execute(text("CREATE SCHEMA public"))
    engine.dispose()
    migrate(layout.store_url)
    made = make_backup(layout.store_url, tmp_path / "one.backup")
    add_passes(layout, "p1")
    restore(layout, made.path)
    assert passes_in(layout) == 0
