"""Nothing but health and the login is reached without a key: not a body, not even a 404."""

import base64
import binascii
from typing import Final
from urllib.parse import quote, urlsplit

from fastapi.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from station.api.gate import Gate
from station.api.logins import CSRF_HEADER, LoggedIn, cookie_in
from station.api.problems import problem_answer
from station.errors import KeyRefused
from station.store.callers import Caller

LOGIN: Final = "/login"
OPEN: Final = frozenset({"/healthz", "/readyz", LOGIN})
_OPEN_BELOW: Final = "/static/"
"""Style and scripts of the pages, which the login needs and which tell nothing."""
_HARMLESS: Final = frozenset({"GET", "HEAD", "OPTIONS"})
PAGES: Final = frozenset({"/docs", "/openapi.json"})
"""For people with a browser, which asks for a name and a password: the key is the password.

Only for these, which change nothing: a browser sends what it was told with every later call to the
station, also one that a page of somebody else makes.
"""
_ASK_A_PERSON: Final = 'Bearer, Basic realm="Treadline: any name, a key as the password"'
_NO_KEY: Final = "this call needs a key; send it as `Authorization: Bearer KEY`"


class Guard:
    """Middleware that finds out who calls: by the key of the call, or else by its login."""

    def __init__(self, app: ASGIApp, gate: Gate) -> None:
        self._app = app
        self._gate = gate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["path"] in OPEN or _is_static(scope["path"]):
            await self._app(scope, receive, send)
            return
        logged_in = None if "authorization" in Headers(scope=scope) else cookie_in(scope)
        try:
            if logged_in is None:
                caller = await self._caller_of_key(scope)
            else:
                caller = await self._caller_of_login(logged_in, scope)
        except KeyRefused as error:
            await _refused(scope, error)(scope, receive, send)
            return
        scope.setdefault("state", {}).update(caller=caller, logged_in=logged_in)
        await self._app(scope, receive, send)

    async def _caller_of_key(self, scope: Scope) -> Caller:
        key = _key_in(scope)
        caller = self._gate.recall(key)
        return caller if caller is not None else await run_in_threadpool(self._admit, key, scope)

    async def _caller_of_login(self, logged_in: LoggedIn, scope: Scope) -> Caller:
        cookie = logged_in.cookie
        caller = self._gate.recall(cookie)
        if caller is None:
            caller = await run_in_threadpool(self._gate.admit_login, cookie)
        if scope["method"] not in _HARMLESS and not logged_in.vouched_for(Headers(scope=scope)):
            raise KeyRefused(
                f"the call has a login but not its {CSRF_HEADER}, as a page of somebody else would "
                "send it; load the station's page anew"
            )
        return caller

    def _admit(self, key: str, scope: Scope) -> Caller:
        host, _ = scope.get("client") or ("nowhere", 0)
        return self._gate.admit(key, host)


def _is_static(path: str) -> bool:
    return path.startswith(_OPEN_BELOW)


def _refused(scope: Scope, error: KeyRefused) -> Response:
    """Return the refusal as who asks can use it: a person is led to the login."""
    headers = Headers(scope=scope)
    if "text/html" in headers.get("Accept", "") and scope["method"] in _HARMLESS:
        asked = scope["path"] + (
            f"?{scope['query_string'].decode('latin-1')}" * bool(scope["query_string"])
        )
        return RedirectResponse(login_leading_to(asked), status_code=303)
    answer = problem_answer(scope["path"], error)
    if "HX-Request" in headers and answer.status_code == 401:
        # A part of a page cannot become the login: the whole page must.
        page = urlsplit(headers.get("HX-Current-URL", ""))
        answer.headers["HX-Redirect"] = login_leading_to(page.path or "/")
    if scope["path"] in PAGES and answer.status_code == 401:
        answer.headers["WWW-Authenticate"] = _ASK_A_PERSON
    return answer


def login_leading_to(address: str) -> str:
    """Return the address of the login that goes on to another one of the station.

    >>> login_leading_to("/passes?train=7")
    '/login?next=/passes%3Ftrain%3D7'
    """
    return f"{LOGIN}?next={quote(address)}"


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
