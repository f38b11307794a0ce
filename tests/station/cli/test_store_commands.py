"""Shows `station backup`, `station restore` and `station audit` as a person uses them."""

import json
from datetime import UTC, datetime

import pytest
from newest_schema import make_store

from station.cli.main import build_app, run
from station.operations import DataLayout
from station.store import Action, Actor, Store, audit
from station.worker import held

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "station.toml"
    path.write_text('data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n')
    (tmp_path / "data").mkdir()
    return path


@pytest.fixture
def layout(config):
    return DataLayout(config.parent / "data")


@pytest.fixture
def station(config, capsys):
    """Run `station ARGUMENTS` and return exit code, stdout and stderr."""

    def command(*arguments):
        code = run(build_app(arguments[0]), [*arguments, "--config", str(config)])
        said = capsys.readouterr()
        return code, said.out, said.err

    return command


@pytest.fixture
def trail(layout):
    """A store with two entries in its audit trail."""
    make_store(layout.store_url)
    store = Store.open(layout.store_url)
    with store.change() as session:
        plc = Actor("plc", "10.0.0.7")
        told = {"axles": 4}
        audit(session, Action.FINISH, "pass", "p1", by=plc, at=NOON, after=told)
        session.flush()
        audit(session, Action.CANCEL, "job", "j1", by=Actor("somebody"), at=NOON)
    store.close()


def test_the_trail_is_a_line_a_change_the_newest_first(station, trail):
    code, out, _ = station("audit")
    assert code == 0
    assert out.splitlines() == [
        "2026-07-01T12:00:00Z  somebody: cancel job j1",
        "2026-07-01T12:00:00Z  plc from 10.0.0.7: finish pass p1 (after axles 4)",
    ]
    _, out, _ = station("audit", "--json", "--who", "plc")
    (entry,) = json.loads(out)["entries"]
    assert (entry["subject"], entry["after"]) == ("p1", {"axles": 4})
    _, out, _ = station("audit", "--limit", "1")
    assert len(out.splitlines()) == 1


def test_a_backup_is_made_and_brought_back(station, trail, tmp_path, layout):
    code, out, _ = station("backup", "--out", str(tmp_path / "one.backup"), "--json")
    assert code == 0
    made = json.loads(out)
    assert (tmp_path / "one.backup.sha256").read_text() == f"{made['sha256']}  one.backup\n"
    code, out, _ = station("restore", str(tmp_path / "one.backup"))
    assert code == 0
    assert "the store before is in" in out
    _, out, _ = station("audit", "--json")
    newest = json.loads(out)["entries"][0]
    assert (newest["action"], newest["kind"]) == ("restore", "store")
    assert newest["who"].endswith("at the command line")


def test_a_station_that_never_ran_has_nothing_to_back_up_and_that_is_no_failure(station, tmp_path):
    out = tmp_path / "one.backup"
    assert station("backup", "--out", str(out))[0] == 2
    code, said, err = station("backup", "--if-any", "--out", str(out))
    assert (code, said, err) == (0, "there is no store yet: nothing to back up\n", "")
    assert not out.exists()


@pytest.mark.usefixtures("once")
def test_each_refusal_is_one_line(station, layout, trail, tmp_path):
    out = tmp_path / "one.backup"
    assert station("backup", "--out", str(out))[0] == 0
    code, _, err = station("backup", "--out", str(out))
    assert (code, err.count("\n")) == (2, 1)
    assert "is there already" in err
    with held(layout.station_lock, "a station"):
        code, _, err = station("restore", str(out))
    assert (code, err.count("\n")) == (2, 1)
    assert "a station runs already" in err


def test_a_station_that_never_ran_has_no_trail_and_gets_no_store(station, layout):
    code, _, err = station("audit")
    assert (code, err.count("\n")) == (2, 1)
    assert "no store yet" in err
    assert not layout.store_file.exists()


def test_a_backup_that_ended_well_is_noted_for_the_metrics(station, trail, layout, tmp_path):
    assert not layout.backup_note.exists()
    assert station("backup", "--out", str(tmp_path / "no-such-folder" / "b.sqlite"))[0] == 2
    assert not layout.backup_note.exists()
    assert station("backup", "--out", str(tmp_path / "b.sqlite"))[0] == 0
    assert layout.backup_note.read_text() == f"{tmp_path / 'b.sqlite'}\n"
