"""Backups in a folder: which is given up, and that nothing else of the folder is touched."""

from datetime import UTC, datetime, timedelta, timezone

import pytest

from station.backups import drop_all_but, next_in
from station.backups.checksums import beside
from station.cli.main import build_app, run
from station.operations import DataLayout
from station.store import migrate

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def made(folder, days):
    path = next_in(folder, NOON + timedelta(days=days))
    path.write_text("a backup")
    beside(path).write_text("its checksum")
    return path


def test_a_backup_is_named_by_its_moment_in_utc(tmp_path):
    berlin = NOON.astimezone(timezone(timedelta(hours=2)))
    assert next_in(tmp_path, berlin).name == "store-20260701T120000Z.backup"


def test_the_oldest_go_with_their_checksums_and_what_is_somebodys_stays(tmp_path):
    backups = [made(tmp_path, day) for day in range(4)]
    by_hand = tmp_path / "store-before-the-flood.backup"
    by_hand.write_text("kept")
    assert drop_all_but(tmp_path, 2) == [backups[1], backups[0]]
    left = {backups[2], beside(backups[2]), backups[3], beside(backups[3]), by_hand}
    assert set(tmp_path.iterdir()) == left


def test_the_command_keeps_so_many_of_a_folder(tmp_path, capsys):
    config, folder = tmp_path / "station.toml", tmp_path / "backups"
    config.write_text('data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n')
    folder.mkdir()
    layout = DataLayout(tmp_path / "data")
    layout.ensure()
    migrate(layout.store_url)
    old = made(folder, -9000)
    arguments = ["backup", "--config", str(config), "--out", str(folder), "--keep", "1"]
    assert run(build_app("backup"), arguments) == 0
    assert not old.exists()
    assert len(list(folder.glob("*.backup"))) == 1


@pytest.mark.parametrize("out", ["store.backup", "nowhere/"])
def test_keeping_some_needs_a_folder(tmp_path, capsys, out):
    arguments = ["backup", "--out", str(tmp_path / out), "--keep", "1"]
    assert run(build_app("backup"), arguments) == 2
    assert "--keep is of a folder" in capsys.readouterr().err
