"""Bearer keys: whose one is, and what it allows.  Kept are only hashes."""

import hashlib
import re
import secrets
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum

from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from station.errors import InputUnusable
from station.store.tables import Key

_FORM = re.compile(r"tl_(?P<id>[0-9a-f]{8})_(?P<secret>[A-Za-z0-9_-]{43})")
_SHORTEST = 32
_NOTED_EVERY = timedelta(minutes=5)


class Scope(StrEnum):
    """What a key allows."""

    READ = "read"
    OPERATE = "operate"
    CALIBRATE = "calibrate"
    ADMIN = "admin"


IMPLIES: dict[Scope, frozenset[Scope]] = {
    Scope.READ: frozenset({Scope.READ}),
    Scope.OPERATE: frozenset({Scope.OPERATE, Scope.READ}),
    Scope.CALIBRATE: frozenset({Scope.CALIBRATE, Scope.READ}),
    Scope.ADMIN: frozenset(Scope),
}


@dataclass(frozen=True, slots=True)
class Caller:
    """Who calls, and what it may do."""

    name: str
    scopes: frozenset[Scope]
    key_id: str | None = None
    """Absent where the key is none of the store."""
    last_used_at: datetime | None = None
    """When the key was noted to be used last."""

    def may(self, scope: Scope) -> bool:
        """Tell whether the caller's scopes include `scope`."""
        return any(scope in IMPLIES[held] for held in self.scopes)


def digest(secret: str) -> str:
    """Return what is kept of a secret.

    One SHA-256 is enough: the secret is 256 random bits, not a password that could be guessed.
    """
    return hashlib.sha256(secret.encode()).hexdigest()


def caller_of(session: Session, text: str, *, at: datetime) -> Caller | None:
    """Return whose key `text` is, or None where it is nobody's, expired or revoked."""
    parts = _FORM.fullmatch(text)
    key = None if parts is None else session.get(Key, parts["id"])
    if parts is None or key is None:
        return None
    if not secrets.compare_digest(digest(parts["secret"]), key.secret_sha256):
        return None
    if not usable(key, at=at):
        return None
    scopes = frozenset(Scope(scope) for scope in key.scopes["scopes"])
    return Caller(key.name, scopes, key_id=key.id, last_used_at=key.last_used_at)


def usable(key: Key, *, at: datetime) -> bool:
    """Tell whether a key is neither revoked nor expired."""
    return key.revoked_at is None and (key.expires_at is None or key.expires_at > at)


def used_lately(caller: Caller, *, at: datetime) -> bool:
    """Tell whether the use of a key need not be noted: a call must not cost a write."""
    noted = caller.last_used_at
    return caller.key_id is None or (noted is not None and at - noted < _NOTED_EVERY)


def note_use(session: Session, caller: Caller, *, at: datetime) -> None:
    """Note that a key was used."""
    if caller.key_id is not None:
        session.execute(update(Key).where(Key.id == caller.key_id).values(last_used_at=at))


def ensure_unguessable(key: str) -> None:
    """Refuse a key of somebody's own making that is too short.

    Raises
    ------
    InputUnusable
        If it has fewer than 32 characters.
    """
    if not len(key) >= _SHORTEST:
        raise InputUnusable(
            f"STATION_ADMIN_KEY has {len(key)} characters; give a random one of {_SHORTEST} or more"
        )


def any_key(session: Session) -> bool:
    """Tell whether a key was ever made."""
    return bool(session.scalar(select(func.count()).select_from(Key)))
