"""Logging in with a browser: a key is changed for a cookie that no script can read.

A browser sends its cookie with every call to the station, also with one that a page of somebody
else makes.  So the cookie goes along only with calls from the station's own pages and with plain
links (`SameSite=Lax`), and what changes anything must carry a token besides, which only the
station's own pages know (OWASP: Cross-Site Request Forgery Prevention).
"""

import hashlib
import secrets
from dataclasses import dataclass, field
from datetime import timedelta
from typing import Final

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import Response
from starlette.types import Scope

from station.api.gate import Gate
from station.operations import Station
from station.store import Action, Actor, audit
from station.store.callers import (
    OpenLogin,
    add_login,
    digest,
    end_login,
    end_login_named,
    login_name,
    open_logins,
)

CSRF_HEADER: Final = "X-CSRF-Token"
_COOKIE: Final = "treadline"
_HOST_COOKIE: Final = "__Host-treadline"
"""The browser takes a cookie of such a name only from the host itself, and only encrypted."""
_KIND: Final = "login"


@dataclass(frozen=True, slots=True)
class LoggedIn:
    """A browser that was let in, as a call of it shows."""

    cookie: str = field(repr=False)

    @property
    def sha256(self) -> str:
        """What is kept of the cookie."""
        return digest(self.cookie)

    @property
    def name(self) -> str:
        """What the login goes by, where others see it."""
        return login_name(self.sha256)

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

    def begin(self, key: str, address: str, *, before: LoggedIn | None = None) -> LoggedIn:
        """Let a browser in by a key.

        Parameters
        ----------
        before
            The login that the browser has had until now; it ends.

        Raises
        ------
        TooManyBadKeys, KeyRefused
            As of `Gate.admit`.
        """
        caller = self.gate.admit(key.strip(), address)
        now, by = self.station.now(), Actor(caller.name, address)
        with self.station.store.change() as session:
            if before is not None:
                end_login(session, before.cookie)
            cookie = add_login(
                session,
                caller,
                environment_sha256=self.gate.environment_sha256,
                at=now,
                expires_at=now + self.lasts,
            )
            logged_in = LoggedIn(cookie)
            audit(session, Action.ADD, _KIND, logged_in.name, by=by, at=now)
        if before is not None:
            self.gate.forget(before.sha256)
        return logged_in

    def end(self, logged_in: LoggedIn, *, by: Actor) -> None:
        """Let a browser out; its cookie is worth nothing any more."""
        with self.station.store.change() as session:
            if end_login(session, logged_in.cookie):
                audit(session, Action.REVOKE, _KIND, logged_in.name, by=by, at=self.station.now())
        self.gate.forget(logged_in.sha256)

    def all(self) -> list[OpenLogin]:
        """Return who is let in now, the latest first."""
        with self.station.store.look() as session:
            found = open_logins(
                session,
                environment_sha256=self.gate.environment_sha256,
                at=self.station.now(),
            )
            return list(found)

    def end_named(self, name: str, *, by: Actor) -> None:
        """Let the browser of a login out, by the login's name.

        Raises
        ------
        NotFound
            If there is no such login any more.
        """
        with self.station.store.change() as session:
            sha256 = end_login_named(session, name)
            audit(session, Action.REVOKE, _KIND, name, by=by, at=self.station.now())
        self.gate.forget(sha256)

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
