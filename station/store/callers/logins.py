"""Browsers that were let in by a key: each holds a cookie as good as the key, for a shift."""

import secrets
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from station.errors import NotFound
from station.store.callers.keys import Caller, Scope, digest, usable
from station.store.tables import Key, Login

_SECRET_BYTES = 32
_ENVIRONMENT = Caller("environment", frozenset({Scope.ADMIN}))
_NAME_LENGTH = 16


@dataclass(frozen=True, slots=True)
class OpenLogin:
    """A browser that is logged in, as others may see it.

    Attributes
    ----------
    name
        What the login goes by: made of its hash, as that is nobody's business.
    caller
        Who was let in.
    """

    name: str
    caller: Caller
    created_at: datetime
    expires_at: datetime


def add_login(
    session: Session,
    caller: Caller,
    *,
    environment_sha256: str | None,
    at: datetime,
    expires_at: datetime,
) -> str:
    """Keep that a browser of the caller is let in; return the text of its cookie, kept nowhere.

    Those that have expired are forgotten on the way.

    Parameters
    ----------
    environment_sha256
        The digest of the key of the environment, where it let the caller in.
    """
    session.execute(delete(Login).where(Login.expires_at <= at))
    text = secrets.token_urlsafe(_SECRET_BYTES)
    of_environment = caller.key_id is None
    session.add(
        Login(
            sha256=digest(text),
            key_id=caller.key_id,
            environment_sha256=environment_sha256 if of_environment else None,
            created_at=at,
            expires_at=expires_at,
        )
    )
    return text


def caller_logged_in(
    session: Session, text: str, *, environment_sha256: str | None, at: datetime
) -> Caller | None:
    """Return who was let in with this cookie; None where the login or its key is no longer good."""
    login = session.get(Login, digest(text))
    return None if login is None else _caller(session, login, environment_sha256, at)


def open_logins(
    session: Session, *, environment_sha256: str | None, at: datetime
) -> Iterator[OpenLogin]:
    """Yield the browsers that are let in at a moment, the latest first."""
    for login in session.scalars(select(Login).order_by(Login.created_at.desc(), Login.sha256)):
        caller = _caller(session, login, environment_sha256, at)
        if caller is not None:
            yield OpenLogin(login_name(login.sha256), caller, login.created_at, login.expires_at)


def login_name(sha256: str) -> str:
    """Return what a login goes by, of the hash of its cookie."""
    return digest(f"login {sha256}")[:_NAME_LENGTH]


def end_login(session: Session, text: str) -> bool:
    """Forget a login by its cookie; return whether it was there."""
    gone = delete(Login).where(Login.sha256 == digest(text)).returning(Login.sha256)
    return session.scalar(gone) is not None


def end_login_named(session: Session, name: str) -> str:
    """Forget a login that somebody else has; return the hash of its cookie.

    Raises
    ------
    NotFound
        If there is none of that name.
    """
    for login in session.scalars(select(Login)):
        if secrets.compare_digest(login_name(login.sha256).encode(), name.encode()):
            session.delete(login)
            return login.sha256
    raise NotFound("this login has ended already")


def _caller(
    session: Session, login: Login, environment_sha256: str | None, at: datetime
) -> Caller | None:
    if login.expires_at <= at:
        return None
    if login.key_id is None:
        return _ENVIRONMENT if login.environment_sha256 == environment_sha256 else None
    key = session.get(Key, login.key_id)
    if key is None or not usable(key, at=at):
        return None
    scopes = frozenset(Scope(scope) for scope in key.scopes["scopes"])
    return Caller(key.name, scopes, key_id=key.id, last_used_at=key.last_used_at)
