"""Shows that a station refuses the store of a newer version in one line that leads back, and that
what the line says does."""

import os
import shlex
from datetime import UTC, datetime

import pytest
from newest_schema import make_store
from sqlalchemy import text

from station.backups import make_backup, newest_restorable, restore_backup
from station.backups.checksums import ensure_checksum
from station.cli.main import build_app, run
from station.operations import DataLayout
from station.store import Actor, revision_of
from station.store.connecting import open_engine

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


@pytest.fixture
def layout(tmp_path):
    layout = DataLayout(tmp_path / "data")
    (layout.root / "backups").mkdir(parents=True)
    make_store(layout.store_url)
    return layout


@pytest.fixture
def config(layout, tmp_path):
    path = tmp_path / "station.toml"
    sensor = '[[sensors]]\nid = "left"\naddress = "127.73.1.2"\n'
    path.write_text(f'data_dir = "data"\nport = 0\n{sensor}')
    return path


def backed_up(layout, name):
    return make_backup(layout.store_url, layout.root / "backups" / name).path


def make_newer(layout):
    """Have the store be one that a later version has brought to its tables."""
    engine = open_engine(layout.store_url)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    engine.dispose()


def station(capsys, *arguments):
    code = run(build_app(arguments[0]), list(arguments))
    return code, capsys.readouterr()


def test_a_newer_store_is_refused_in_a_line_whose_command_goes_back(layout, config, capsys):
    known = revision_of(layout.store_url)
    backed_up(layout, "store-20260101T000000Z.backup")
    before = backed_up(layout, "before-9-20260201T000000Z.backup")
    make_newer(layout)
    backed_up(layout, "store-20260301T000000Z.backup")  # by the newer version: leads nowhere
    code, said = station(capsys, "serve", "--config", str(config))
    assert code == 2
    (line,) = said.err.splitlines()
    assert "at revision 9999" in line
    command = f"station restore {before} --config {config}"
    assert line.endswith(f"or restore an older backup: {command}")

    code, said = station(capsys, *shlex.split(command)[1:])
    assert code == 0
    assert "is the station's store now" in said.out
    assert revision_of(layout.store_url) == known


def test_without_a_backup_of_this_version_the_line_names_none(layout, config, capsys):
    make_newer(layout)
    backed_up(layout, "before-9.backup")
    (layout.root / "backups" / "rubbish.backup").write_bytes(b"SQLite format 3\x00 and no more")
    code, said = station(capsys, "serve", "--config", str(config))
    assert code == 2
    (line,) = said.err.splitlines()
    assert line.endswith("restore an older backup")


def test_looking_for_the_way_back_leaves_the_backups_as_they_are(layout):
    made = backed_up(layout, "one.backup")
    assert newest_restorable(layout) == made
    ensure_checksum(made)
    assert sorted(path.name for path in made.parent.iterdir()) == [
        "one.backup",
        "one.backup.sha256",
    ]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root brings back what is another's")
def test_what_root_brings_back_is_its_owners(layout):
    os.chown(layout.root, 4242, 4243)
    made = backed_up(layout, "one.backup")
    restore_backup(layout, made, by=Actor("root"), at=NOON)
    found = layout.store_file.stat()
    assert (found.st_uid, found.st_gid) == (4242, 4243)
