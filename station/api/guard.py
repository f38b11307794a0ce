"""Nothing but health is reached without a key: not a route, not a body, not even a 404."""

from typing import Final

from fastapi.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from station.api.gate import Gate
from station.api.problems import problem_answer
from station.errors import KeyRefused
from station.store import Caller

OPEN: Final = frozenset({"/healthz", "/readyz"})


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
            caller = await run_in_threadpool(self._caller, Headers(scope=scope))
        except KeyRefused as error:
            await problem_answer(scope["path"], error)(scope, receive, send)
            return
        scope.setdefault("state", {})["caller"] = caller
        await self._app(scope, receive, send)

    def _caller(self, headers: Headers) -> Caller:
        scheme, _, key = headers.get("Authorization", "").partition(" ")
        if scheme.lower() != "bearer" or not key:
            raise KeyRefused("this call needs a key; send it as `Authorization: Bearer KEY`")
        return self._gate.admit(key.strip())
