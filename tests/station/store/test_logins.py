"""Shows, on both databases, whom a cookie lets in and until when.  Browsers and cookies themselves
are shown with the API."""

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import select

from station.errors import NotFound
from station.store import Key, Login, Store, migrate
from station.store.callers import (
    Caller,
    Scope,
    add_key,
    add_login,
    caller_logged_in,
    caller_of,
    end_login,
    end_login_named,
    login_name,
    open_logins,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
SHIFT = timedelta(hours=12)
ENVIRONMENT = Caller("environment", frozenset({Scope.ADMIN}))


def begin(session, caller, *, at=NOON, environment=None):
    return add_login(session, caller, environment_sha256=environment, at=at, expires_at=at + SHIFT)


def who(session, cookie, *, at=NOON, environment=None):
    return caller_logged_in(session, cookie, environment_sha256=environment, at=at)


@pytest.fixture
def key(store):
    """A key of the store, as its caller."""
    with store.change() as session:
        text = add_key(session, "tablet 1", [Scope.OPERATE], at=NOON)
        session.flush()
        return caller_of(session, text, at=NOON)


def test_a_cookie_stands_for_its_key_until_the_shift_is_over(store, key):
    with store.change() as session:
        cookie = begin(session, key)
    with store.look() as session:
        almost = who(session, cookie, at=NOON + SHIFT - timedelta(seconds=1))
        assert (almost.name, almost.key_id, almost.scopes) == ("tablet 1", key.key_id, key.scopes)
        assert who(session, cookie, at=NOON + SHIFT) is None


def test_only_the_hash_of_a_cookie_is_kept(store, key):
    with store.change() as session:
        cookie = begin(session, key)
    with store.look() as session:
        (login,) = session.scalars(select(Login))
        kept = {getattr(login, column.key) for column in Login.__table__.columns}
    assert cookie not in kept
    assert who_is_in(store) == [login_name(login.sha256)]
    assert login.sha256[:16] not in who_is_in(store)


def who_is_in(store, **asked):
    with store.look() as session:
        found = list(open_logins(session, environment_sha256=None, at=asked.get("at", NOON)))
    return [each.name for each in found]


@pytest.mark.parametrize("field", ["revoked_at", "expires_at"])
def test_a_login_ends_with_its_key(store, key, field):
    with store.change() as session:
        cookie = begin(session, key)
        setattr(session.get(Key, key.key_id), field, NOON)
    with store.look() as session:
        assert who(session, cookie) is None
    assert who_is_in(store) == []


def test_a_login_by_the_key_of_the_environment_ends_when_that_is_another(store):
    with store.change() as session:
        cookie = begin(session, ENVIRONMENT, environment="a" * 64)
    with store.look() as session:
        assert who(session, cookie, environment="a" * 64).may(Scope.ADMIN)
        assert who(session, cookie, environment="b" * 64) is None
        assert who(session, cookie, environment=None) is None


def test_logging_out_ends_one_login_and_no_other(store, key):
    with store.change() as session:
        first, second = begin(session, key), begin(session, key)
    with store.change() as session:
        assert end_login(session, first)
        assert not end_login(session, first)
    with store.look() as session:
        assert who(session, first) is None
        assert who(session, second) is not None


def test_a_login_is_ended_by_its_name_and_then_there_is_none(store, key):
    with store.change() as session:
        cookie = begin(session, key)
    (name,) = who_is_in(store)
    with store.change() as session:
        end_login_named(session, name)
    with store.look() as session:
        assert who(session, cookie) is None
    with pytest.raises(NotFound, match="ended already"), store.change() as session:
        end_login_named(session, name)


def test_logins_that_are_over_are_forgotten_at_the_next_one(store, key):
    with store.change() as session:
        begin(session, key)
        begin(session, key, at=NOON + timedelta(hours=1))
    later = NOON + SHIFT
    with store.change() as session:
        begin(session, key, at=later)
    with store.look() as session:
        assert len(session.scalars(select(Login)).all()) == 2
    assert len(who_is_in(store, at=later)) == 2


def test_going_back_before_logins_lets_everybody_out_and_forth_nobody_in(store, any_url, key):
    with store.change() as session:
        begin(session, key)
    store.close()
    migrate(any_url, "0013", losing=True)
    migrate(any_url)
    again = Store.open(any_url)
    assert who_is_in(again) == []
    again.close()
