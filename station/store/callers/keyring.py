"""Making keys, changing them for others, and taking them back."""

import re
import secrets
from collections.abc import Iterable, Sequence
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.errors import InputUnusable, NotFound, StateConflict
from station.store.callers.keys import Scope, digest, usable
from station.store.tables import Key

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._@-]{0,63}")


def add_key(
    session: Session,
    name: str,
    scopes: Iterable[Scope],
    *,
    at: datetime,
    expires_at: datetime | None = None,
) -> str:
    """Make a key and return its text, which is nowhere else to be had."""
    key_id, secret = secrets.token_hex(4), secrets.token_urlsafe(32)
    session.add(
        Key(
            id=key_id,
            name=name,
            scopes={"scopes": sorted(scopes)},
            secret_sha256=digest(secret),
            created_at=at,
            expires_at=expires_at,
        )
    )
    return f"tl_{key_id}_{secret}"


def issue_key(
    session: Session,
    name: str,
    scopes: Iterable[Scope],
    *,
    at: datetime,
    expires_at: datetime | None = None,
) -> str:
    """Make a key for somebody who has none, and return its text.

    Raises
    ------
    InputUnusable
        If the name is none, there is no scope, or the key would be expired at once.
    StateConflict
        If somebody of that name has a key: a name says who did what, so it is one holder's.
    """
    if not _NAME.fullmatch(name):
        raise InputUnusable(
            f"name {name!r}: letters, digits, spaces and . _ @ -, at most 64, as 'controller 1'"
        )
    wanted = frozenset(scopes)
    if not wanted:
        raise InputUnusable(f"a key without a scope opens nothing; give {', '.join(Scope)}")
    if expires_at is not None and not (expires_at > at):
        raise InputUnusable(f"{expires_at.isoformat()} is over; give a time to come")
    holders = [key for key in keys_of(session) if key.name == name and usable(key, at=at)]
    if holders:
        raise StateConflict(
            f"{name!r} has key {holders[0].id}; rotate or revoke that, or give another name"
        )
    return add_key(session, name, wanted, at=at, expires_at=expires_at)


def keys_of(session: Session) -> Sequence[Key]:
    """Return all keys that were ever made, oldest first."""
    return session.scalars(select(Key).order_by(Key.created_at, Key.id)).all()


def the_key(session: Session, key_id: str) -> Key:
    """Return a key by its id, which is the second part of its text.

    Raises
    ------
    NotFound
        If there is none.  The message repeats nothing: somebody may have given the whole key.
    """
    key = session.get(Key, key_id)
    if key is None:
        raise NotFound("there is no key of that id; `station keys list` shows those there are")
    return key


def revoke_key(session: Session, key_id: str, *, at: datetime) -> Key:
    """Take a key back, from now on; a second time changes nothing."""
    key = the_key(session, key_id)
    key.revoked_at = key.revoked_at or at
    return key


def rotate_key(
    session: Session,
    key_id: str,
    *,
    at: datetime,
    old_until: datetime,
    expires_at: datetime | None = None,
) -> str:
    """Make a key of the same name and scopes, and have the old one expire; return the new text.

    Raises
    ------
    NotFound
        If there is no such key.
    StateConflict
        If it is no longer good: what was taken back is not handed out again.
    """
    old = the_key(session, key_id)
    if not usable(old, at=at):
        raise StateConflict(f"key {old.id} of {old.name!r} is no longer good; create a new one")
    scopes = [Scope(scope) for scope in old.scopes["scopes"]]
    old.expires_at = old_until if old.expires_at is None else min(old.expires_at, old_until)
    return add_key(session, old.name, scopes, at=at, expires_at=expires_at)
