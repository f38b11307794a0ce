"""Giving keys out and taking them back; each with its line in the audit trail."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timedelta

from station.errors import InputUnusable
from station.store import Action, Actor, Key, Store, audit
from station.store.callers import Scope, issue_key, keys_of, revoke_key, rotate_key

_LONGEST_OVERLAP = timedelta(days=90)
_KIND = "key"


@dataclass(frozen=True, slots=True)
class Keys:
    """The keys of a station, and who changes them."""

    store: Store
    by: Actor
    now: datetime

    def list(self) -> list[Key]:
        """Return all keys that were ever made, oldest first; none with its text."""
        with self.store.look() as session:
            return list(keys_of(session))

    def create(self, name: str, scopes: Iterable[Scope], expires_at: datetime | None) -> str:
        """Make a key for somebody who has none, and return its text, which is kept nowhere.

        Raises
        ------
        InputUnusable
            If name, scopes or time cannot be.
        StateConflict
            If somebody of that name has a key.
        """
        held = frozenset(scopes)
        with self.store.change() as session:
            text = issue_key(session, name, held, at=self.now, expires_at=expires_at)
            audit(
                session,
                Action.ADD,
                _KIND,
                key_id_of(text),
                by=self.by,
                at=self.now,
                after={"name": name, "scopes": sorted(held)},
            )
        return text

    def rotate(self, key_id: str, overlap: timedelta, expires_at: datetime | None) -> str:
        """Make a key in place of another, which stays good for the overlap; return the new text.

        Raises
        ------
        InputUnusable
            If the overlap is negative or longer than 90 days.
        NotFound, StateConflict
            If there is no such key, or it is no longer good.
        """
        if not (timedelta(0) <= overlap <= _LONGEST_OVERLAP):
            raise InputUnusable("the old key may stay good for 0 to 2160 hours (90 days)")
        old_until = self.now + overlap
        with self.store.change() as session:
            text = rotate_key(
                session, key_id, at=self.now, old_until=old_until, expires_at=expires_at
            )
            audit(
                session,
                Action.ADD,
                _KIND,
                key_id_of(text),
                by=self.by,
                at=self.now,
                after={"in_place_of": key_id, "old_until": old_until.isoformat()},
            )
        return text

    def revoke(self, key_id: str) -> Key:
        """Take a key back, from now on; a second time changes nothing.

        Raises
        ------
        NotFound
            If there is no such key.
        """
        with self.store.change() as session:
            key = revoke_key(session, key_id, at=self.now)
            if key.revoked_at == self.now:
                audit(session, Action.REVOKE, _KIND, key.id, by=self.by, at=self.now)
        return key


def key_id_of(text: str) -> str:
    """Return the id in the text of a key, which is no secret.

    >>> key_id_of("tl_0a1b2c3d_secret_secret")
    '0a1b2c3d'
    """
    return text.split("_", 2)[1]
