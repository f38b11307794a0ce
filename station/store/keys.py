"""Bearer keys: made once, kept only as hashes."""

import hashlib
import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from station.errors import InputUnusable
from station.store.tables import Key

_PREFIX = "tl"
_SHORTEST = 32


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

    def may(self, scope: Scope) -> bool:
        """Tell whether the caller's scopes include `scope`."""
        return any(scope in IMPLIES[held] for held in self.scopes)


def digest(secret: str) -> str:
    """Return what is kept of a secret.

    One SHA-256 is enough: the secret is 256 random bits, not a password that could be guessed.
    """
    return hashlib.sha256(secret.encode()).hexdigest()


def add_key(session: Session, name: str, scopes: Iterable[Scope], *, at: datetime) -> str:
    """Make a key and return its text, which is nowhere else to be had."""
    key_id, secret = secrets.token_hex(4), secrets.token_urlsafe(32)
    session.add(
        Key(
            id=key_id,
            name=name,
            scopes={"scopes": sorted(scopes)},
            secret_sha256=digest(secret),
            created_at=at,
        )
    )
    return f"{_PREFIX}_{key_id}_{secret}"


def caller_of(session: Session, text: str, *, at: datetime) -> Caller | None:
    """Return whose key `text` is, or None where it is nobody's, expired or revoked."""
    prefix, _, rest = text.partition("_")
    key_id, _, secret = rest.partition("_")
    key = session.get(Key, key_id) if prefix == _PREFIX else None
    if key is None or not secrets.compare_digest(digest(secret), key.secret_sha256):
        return None
    if key.revoked_at is not None or (key.expires_at is not None and key.expires_at <= at):
        return None
    return Caller(key.name, frozenset(Scope(scope) for scope in key.scopes["scopes"]))


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
