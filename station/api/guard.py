"""Nothing but health is reached without a key: not a route, not a body, not even a 404."""

import base64
import binascii
from typing import Final

from fastapi.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from station.api.gate import Gate
from station.api.problems import problem_answer
from station.errors import KeyRefused
from station.store import Caller

OPEN: Final = frozenset({"/healthz", "/readyz"})
PAGES: Final = frozenset({"/docs", "/openapi.json"})
"""For people with a browser, which asks for a name and a password: the key is the password.

Only for these, which change nothing: a browser sends what it was told with every later call to the
station, also one that a page of somebody else makes.
"""
_ASK_A_PERSON: Final = 'Bearer, Basic realm="Treadline: any name, a key as the password"'
_NO_KEY: Final = "this call needs a key; send it as `Authorization: Bearer KEY`"


class Guard:
    """Middleware that finds out who calls."""

    def __init__(self, app: ASGIApp, gate: Gate) -> None:
        self._app = app
        self._gate = gate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["path"] in OPEN:
            await self._app(scope, receive, send)
            return
        try:
            key = _key_in(scope)
            caller = self._gate.recall(key) or await run_in_threadpool(self._admit, key, scope)
        except KeyRefused as error:
            answer = problem_answer(scope["path"], error)
            if scope["path"] in PAGES and answer.status_code == 401:
                answer.headers["WWW-Authenticate"] = _ASK_A_PERSON
            await answer(scope, receive, send)
            return
        scope.setdefault("state", {})["caller"] = caller
        await self._app(scope, receive, send)

    def _admit(self, key: str, scope: Scope) -> Caller:
        host, _ = scope.get("client") or ("nowhere", 0)
        return self._gate.admit(key, host)


def _key_in(scope: Scope) -> str:
    """Return the key that a call carries; KeyRefused where there is none, or not one alone."""
    given = Headers(scope=scope).getlist("Authorization")
    if len(given) > 1:
        raise KeyRefused("two Authorization headers; send one")
    scheme, _, credentials = "".join(given).partition(" ")
    key = credentials.strip()
    if scheme.lower() == "basic" and scope["path"] in PAGES:
        key = _password_in(key)
    elif scheme.lower() != "bearer":
        key = ""
    if not key:
        raise KeyRefused(_NO_KEY)
    return key


def _password_in(credentials: str) -> str:
    """Return the password of HTTP Basic credentials; empty where they are none.

    >>> _password_in("YW5ib2R5OnRsXzFfMg==")
    'tl_1_2'
    """
    try:
        text = base64.b64decode(credentials, validate=True).decode()
    except (binascii.Error, ValueError):
        return ""
    return text.partition(":")[2]
