"""Logging in with a browser: a key is changed for a cookie that no script can read.

A browser sends its cookie with every call to the station, also with one that a page of somebody
else makes.  So the cookie goes along only with calls from the station's own pages and with plain
links (`SameSite=Lax`), and what changes anything must carry a token besides, which only the
station's own pages know (OWASP: Cross-Site Request Forgery Prevention).
"""

import hashlib
import secrets
from dataclasses import dataclass
from datetime import timedelta
from typing import Final

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import Response
from starlette.types import Scope

from station.api.gate import Gate
from station.operations import Station
from station.store import Action, Actor, add_login, audit, end_login

CSRF_HEADER: Final = "X-CSRF-Token"
_COOKIE: Final = "treadline"
_HOST_COOKIE: Final = "__Host-treadline"
"""The browser takes a cookie of such a name only from the host itself, and only encrypted."""


@dataclass(frozen=True, slots=True)
class LoggedIn:
    """A browser that was let in, as a call of it shows."""

    cookie: str

    @property
    def csrf_token(self) -> str:
        """What this browser's pages send along with calls that change something."""
        return hashlib.sha256(f"csrf {self.cookie}".encode()).hexdigest()

    def vouched_for(self, headers: Headers) -> bool:
        """Tell whether a call comes from one of the station's own pages."""
        given = headers.get(CSRF_HEADER, "")
        return secrets.compare_digest(given.encode(), self.csrf_token.encode())


@dataclass(frozen=True, slots=True)
class Logins:
    """Lets browsers in and out."""

    station: Station
    gate: Gate

    def begin(self, key: str, address: str) -> LoggedIn:
        """Let a browser in by a key.

        Raises
        ------
        TooManyBadKeys, KeyRefused
            As of `Gate.admit`.
        """
        caller = self.gate.admit(key.strip(), address)
        now = self.station.now()
        with self.station.store.change() as session:
            cookie = add_login(
                session,
                caller,
                environment_sha256=self.gate.environment_sha256,
                at=now,
                expires_at=now + self.lasts,
            )
            by = Actor(caller.name, address)
            audit(session, Action.ADD, "login", caller.key_id or "environment", by=by, at=now)
        return LoggedIn(cookie)

    def end(self, logged_in: LoggedIn) -> None:
        """Let a browser out; its cookie is worth nothing any more."""
        with self.station.store.change() as session:
            end_login(session, logged_in.cookie)
        self.gate.forget(logged_in.cookie)

    @property
    def lasts(self) -> timedelta:
        """How long a login lasts."""
        return timedelta(hours=self.station.settings.web.login_h)

    def give(self, response: Response, logged_in: LoggedIn, *, encrypted: bool) -> None:
        """Hand the cookie out with a response."""
        response.set_cookie(
            _HOST_COOKIE if encrypted else _COOKIE,
            logged_in.cookie,
            max_age=int(self.lasts.total_seconds()),
            path="/",
            secure=encrypted,
            httponly=True,
            samesite="lax",
        )

    @staticmethod
    def take_back(response: Response, *, encrypted: bool) -> None:
        """Have the browser forget its cookie."""
        response.delete_cookie(
            _HOST_COOKIE if encrypted else _COOKIE, path="/", secure=encrypted, httponly=True
        )


def cookie_in(scope: Scope) -> LoggedIn | None:
    """Return the login that a call carries, if it carries one."""
    given = cookie_parser(Headers(scope=scope).get("cookie", ""))
    cookie = given.get(_HOST_COOKIE if scope["scheme"] == "https" else _COOKIE)
    return LoggedIn(cookie) if cookie else None
