"""What happens around every request: an id, a log line, a count, and cautious headers."""

import time
from typing import Final

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.api.metrics import Metrics
from station.api.problems import unforeseen_answer
from station.api.request_log import REQUEST_ID, about_call, note_answer, request_id_of

_HEADERS: Final = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
}
_STAY_ENCRYPTED: Final = ("Strict-Transport-Security", "max-age=31536000")


class Watch:
    """Middleware; a plain ASGI one, so that streams pass through unbuffered."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request_id, began_s, status, begun = request_id_of(scope), time.perf_counter(), 500, False

        async def send_watched(message: Message) -> None:
            nonlocal status, begun
            if message["type"] == "http.response.start":
                status, begun = message["status"], True
                headers = MutableHeaders(scope=message)
                headers[REQUEST_ID] = request_id
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
                if scope["scheme"] == "https":
                    headers.setdefault(*_STAY_ENCRYPTED)
            await send(message)

        with about_call(scope, request_id):
            try:
                await self._app(scope, receive, send_watched)
            except Exception as error:
                # Here, as the framework answers outside of this: without an id, without headers.
                answer = unforeseen_answer(scope["path"], error)
                if begun:
                    raise  # the server breaks the answer off, and the caller sees that
                await answer(scope, receive, send_watched)
            finally:
                self._note(scope, status, time.perf_counter() - began_s)

    def _note(self, scope: Scope, status: int, seconds: float) -> None:
        # An address that no route knows is counted as one: names from outside never become labels.
        route = getattr(scope.get("route"), "path", "unknown")
        self._metrics.count(scope["method"], route, status, seconds)
        note_answer(scope, status, seconds)
