"""Browsers that were let in by a key: each holds a cookie as good as the key, for a shift."""

import secrets
from datetime import datetime

from sqlalchemy import delete
from sqlalchemy.orm import Session

from station.store.keys import Caller, Scope, digest, usable
from station.store.login_table import Login
from station.store.tables import Key

_SECRET_BYTES = 32


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
    if login is None or login.expires_at <= at:
        return None
    if login.key_id is None:
        unchanged = login.environment_sha256 == environment_sha256
        return Caller("environment", frozenset({Scope.ADMIN})) if unchanged else None
    key = session.get(Key, login.key_id)
    if key is None or not usable(key, at=at):
        return None
    scopes = frozenset(Scope(scope) for scope in key.scopes["scopes"])
    return Caller(key.name, scopes, key_id=key.id, last_used_at=key.last_used_at)


def end_login(session: Session, text: str) -> None:
    """Forget a login; one that is not there is no matter."""
    session.execute(delete(Login).where(Login.sha256 == digest(text)))
