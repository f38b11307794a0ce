"""Refusals as a page, where it is a person that goes to an address."""

import json
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.page.shell import Shell

_PROBLEM: Final = "application/problem+json"
_OF_THE_PAGE: Final = frozenset({
    "content-length",
    "content-type",
    "content-security-policy",
    "referrer-policy",
})


class AnswersForPeople:
    """Middleware around all others: what they refuse is told in words, with a way on."""

    def __init__(self, app: ASGIApp, shell: Shell) -> None:
        self._app = app
        self._shell = shell

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if not _goes_there(scope):
            await self._app(scope, receive, send)
            return
        start: Message | None = None
        body = b""

        async def send_for_people(message: Message) -> None:
            nonlocal start, body
            if message["type"] == "http.response.start" and _is_problem(message):
                start = message
            elif start is None:
                await send(message)
            else:
                body += message.get("body", b"")
                if not message.get("more_body", False):
                    await self._tell(scope, start, body, receive, send)

        await self._app(scope, receive, send_for_people)

    async def _tell(
        self, scope: Scope, start: Message, body: bytes, receive: Receive, send: Send
    ) -> None:
        page = self._shell.page(
            Request(scope),
            "shell/problem.html",
            status=start["status"],
            problem=json.loads(body),
            active=None,
        )
        for name, value in MutableHeaders(scope=start).items():
            if name not in _OF_THE_PAGE:
                page.headers[name] = value
        await page(scope, receive, send)


def _goes_there(scope: Scope) -> bool:
    """Tell whether a browser goes to the address, rather than a script or a program calls it."""
    if scope["type"] != "http":
        return False
    headers = Headers(scope=scope)
    return "text/html" in headers.get("accept", "") and "hx-request" not in headers


def _is_problem(start: Message) -> bool:
    return Headers(raw=start["headers"]).get("content-type", "").startswith(_PROBLEM)
