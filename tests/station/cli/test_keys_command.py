"""Shows `station keys` as a person uses it: what it prints, and that a key is printed once."""

import json

import pytest

from station.cli.main import build_app, run
from station.operations import DataLayout, utc_now
from station.store import Store
from station.store.callers import caller_of
from station.store.lists import audit_page


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "station.toml"
    path.write_text('data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n')
    return path


@pytest.fixture
def keys(config, capsys):
    """Run `station keys ARGUMENTS` and return exit code and what is printed, as data."""
    app = build_app("keys")

    def command(*arguments):
        code = run(app, ["keys", *arguments, "--config", str(config), "--json"])
        out, err = capsys.readouterr()
        return code, json.loads(out) if out else err

    return command


@pytest.fixture
def store(config):
    store = Store.open(DataLayout(config.parent / "data").store_url)
    yield store
    store.close()


def test_a_key_is_made_listed_rotated_and_revoked(keys, store):
    assert keys("list") == (0, {"keys": []})
    code, made = keys("create", "controller 1", "--scope", "operate", "--expires-days", "30")
    assert code == 0
    with store.look() as session:
        assert caller_of(session, made["key"], at=utc_now()).name == "controller 1"
    code, listed = keys("list")
    (row,) = listed["keys"]
    assert (row["id"], row["scopes"], row["good"]) == (made["id"], ["operate"], True)
    assert made["key"] not in json.dumps(listed)

    code, successor = keys("rotate", made["id"], "--keep-hours", "1")
    assert code == 0
    # Whoever pastes the whole key means its id.
    assert keys("revoke", made["key"])[0] == 0
    goods = {row["id"]: row["good"] for row in keys("list")[1]["keys"]}
    assert goods == {made["id"]: False, successor["id"]: True}


def test_every_change_of_a_key_is_in_the_audit_trail_without_the_key(keys, store):
    _, made = keys("create", "planner", "--scope", "read")
    keys("rotate", made["id"])
    keys("revoke", made["id"])
    with store.look() as session:
        trail = audit_page(session, limit=10).rows
    assert [(entry.action, entry.kind) for entry in trail] == [
        ("revoke", "key"),
        ("add", "key"),
        ("add", "key"),
    ]
    assert {entry.who.partition(" at ")[2] for entry in trail} == {"the command line"}
    assert made["key"].split("_")[2] not in str([entry.after for entry in trail])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["create", "x", "--scope", "everything"], "is not one of"),
        (["create", "x"], "--scope"),
        (["create", "a\nb", "--scope", "read"], "name"),
        (["create", "x", "--scope", "read", "--expires-days", "nan"], "0 to 3650"),
        (["rotate", "nosuch"], "no key of that id"),
        (["revoke", "tl_00000000_aaaa"], "no key of that id"),
    ],
)
def test_a_mistake_is_one_line_and_exit_2(keys, arguments, says):
    code, err = keys(*arguments)
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
