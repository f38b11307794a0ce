"""Shows who gets a key and who does not, and that none can be read again."""

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import text

from station.errors import InputUnusable, NotFound, StateConflict
from station.store.callers import (
    Scope,
    caller_of,
    issue_key,
    keys_of,
    revoke_key,
    rotate_key,
    usable,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def issue(store, name="controller", scopes=(Scope.OPERATE,), **more):
    with store.change() as session:
        return issue_key(session, name, scopes, at=NOON, **more)


def caller(store, key, at=NOON):
    with store.look() as session:
        return caller_of(session, key, at=at)


def test_a_key_is_its_holders_name_and_scopes_and_nothing_of_it_is_kept(store):
    key = issue(store)
    found = caller(store, key)
    assert (found.name, found.scopes) == ("controller", {Scope.OPERATE})
    secret = key.split("_", 2)[2]
    with store.look() as session:
        rows = session.execute(text("SELECT * FROM keys")).all()
    assert secret not in str(rows)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda key: key[:-1],
        lambda key: key + "A",
        lambda key: key.upper(),
        lambda key: key[:12] + "A" * 43,
        lambda key: f"tl_00000000_{key[12:]}",
        lambda key: f"{key[:10]}\x00{key[11:]}",
        lambda key: f"{key}\n",
    ],
)
def test_whatever_differs_in_one_letter_is_no_key(store, spoil):
    key = issue(store)
    assert caller(store, spoil(key)) is None


def test_a_key_ends_at_its_time_and_not_before(store):
    key = issue(store, expires_at=NOON + timedelta(hours=1))
    assert caller(store, key, NOON + timedelta(minutes=59)) is not None
    assert caller(store, key, NOON + timedelta(hours=1)) is None


def test_a_name_is_one_holders_until_its_key_is_no_longer_good(store):
    issue(store)
    with pytest.raises(StateConflict, match="rotate or revoke"):
        issue(store)
    with store.change() as session:
        revoke_key(session, keys_of(session)[0].id, at=NOON)
    issue(store)


@pytest.mark.parametrize("name", ["", " a", "a\nb", "a\x00", "x" * 65, "../a"])
def test_a_name_that_would_not_show_in_a_line_is_refused(store, name):
    with pytest.raises(InputUnusable, match="name"):
        issue(store, name)


def test_a_key_without_scope_or_future_is_refused(store):
    with pytest.raises(InputUnusable, match="scope"):
        issue(store, scopes=())
    with pytest.raises(InputUnusable, match="over"):
        issue(store, expires_at=NOON)


def test_a_successor_has_the_same_scopes_and_never_lengthens_the_life_of_the_old_one(store):
    end = NOON + timedelta(hours=2)
    old = issue(store, expires_at=end)
    with store.change() as session:
        (key,) = keys_of(session)
        new = rotate_key(session, key.id, at=NOON, old_until=NOON + timedelta(days=1))
    assert caller(store, new, end).scopes == {Scope.OPERATE}
    assert caller(store, old, end) is None


def test_what_is_no_longer_good_has_no_successor(store):
    issue(store)
    with store.change() as session:
        key = revoke_key(session, keys_of(session)[0].id, at=NOON)
        assert not usable(key, at=NOON)
        with pytest.raises(StateConflict, match="no longer good"):
            rotate_key(session, key.id, at=NOON, old_until=NOON)


def test_the_refusal_of_an_id_that_is_none_does_not_repeat_it(store):
    with store.change() as session, pytest.raises(NotFound) as refusal:
        revoke_key(session, "a-whole-key-pasted-by-mistake", at=NOON)
    assert "mistake" not in str(refusal.value)
