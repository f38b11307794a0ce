"""What happens around every request: an id, a log line, a count, and cautious headers."""

import time
from typing import Final
from uuid import uuid4

import structlog
from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.api.guard import OPEN
from station.api.metrics import Metrics

_log = structlog.get_logger()
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
        request_id, began_s, status = uuid4().hex[:12], time.perf_counter(), 500

        async def send_watched(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = MutableHeaders(scope=message)
                headers["X-Request-Id"] = request_id
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
                if scope["scheme"] == "https":
                    headers.setdefault(*_STAY_ENCRYPTED)
            await send(message)

        with structlog.contextvars.bound_contextvars(request=request_id):
            try:
                await self._app(scope, receive, send_watched)
            finally:
                self._note(scope, status, time.perf_counter() - began_s)

    def _note(self, scope: Scope, status: int, seconds: float) -> None:
        # An address that no route knows is counted as one: names from outside never become labels.
        route = getattr(scope.get("route"), "path", "unknown")
        self._metrics.count(scope["method"], route, status, seconds)
        if scope["path"] in OPEN:  # asked by probes every second
            return
        _log.info(
            "answered",
            method=scope["method"],
            path=scope["path"],
            status=status,
            ms=round(1000.0 * seconds, 1),
        )
