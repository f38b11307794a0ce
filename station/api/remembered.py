"""Answers that are still true are given again: who polls asks the same, and mostly nothing changed.

An answer that was made of the store alone is true until somebody writes to a table that was read
for it, which SQLite tells at the cost of microseconds.  On PostgreSQL nothing tells it, and every
answer is made anew.
"""

import asyncio
import time
from collections import OrderedDict
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.store import Revision, Revisions, Store, tables_read

_Endpoint = TypeVar("_Endpoint", bound=Callable[..., Any])
_GOOD_FOR_S: Final[dict[Callable[..., Any] | None, float]] = {}
_MOMENT_S: Final = 0.25
"""How old what a capture process tells may be; a person sees no difference."""
_MOST: Final = 64
_LARGEST_BYTES: Final = 512_000
_ASKS_FOR_LESS: Final = frozenset({"if-none-match", "range"})

_Key = tuple[str, bytes, tuple[str, str], frozenset[str]]


def from_the_store(endpoint: _Endpoint) -> _Endpoint:
    """Mark a route whose answer depends on its address and the store alone."""
    _GOOD_FOR_S[endpoint] = float("inf")
    return endpoint


def for_a_moment(endpoint: _Endpoint) -> _Endpoint:
    """Mark a route that tells of processes and the host, too: its answer is good for 0.25 s."""
    _GOOD_FOR_S[endpoint] = _MOMENT_S
    return endpoint


@dataclass(frozen=True, slots=True)
class _Kept:
    made_of: Mapping[str, int]
    until_s: float
    route: Any
    headers: tuple[tuple[bytes, bytes], ...]
    body: bytes


class Remembered:
    """Middleware behind the guard: who may not ask is not answered from here either."""

    def __init__(self, app: ASGIApp, store: Store) -> None:
        self._app = app
        self._revisions: Revisions = store.revisions()
        self._kept: OrderedDict[_Key, _Kept] = OrderedDict()
        self._being_made: dict[tuple[_Key, Revision], asyncio.Future[None]] = {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        key = _key_of(scope)
        revision = None if key is None else self._revisions.now()
        if key is None or revision is None:
            await self._app(scope, receive, send)
            return
        kept = self._still_true(key, revision) or await self._made_by_another(key, revision)
        if kept is not None:
            scope["route"] = kept.route  # for who counts calls by it
            await send(_start(kept.headers))
            await send({"type": "http.response.body", "body": kept.body})
            return
        with self._making(key, revision):
            answer = _Answer(send)
            with tables_read() as tables:
                await self._app(scope, receive, answer.watched)
            route = scope.get("route")
            good_for_s = _GOOD_FOR_S.get(getattr(route, "endpoint", None))
            if good_for_s is not None and answer.headers is not None:
                until_s = time.monotonic() + good_for_s
                # Of before the store was read: what changed meanwhile has another number.
                made_of = revision.of(tables)
                found = _Kept(made_of, until_s, route, answer.headers, bytes(answer.body))
                self._keep(key, found)

    @contextmanager
    def _making(self, key: _Key, revision: Revision) -> Generator[None]:
        """Let others wait for an answer that is kept; whether it is, its last time tells."""
        if key not in self._kept or (key, revision) in self._being_made:
            yield
            return
        done = self._being_made[key, revision] = asyncio.get_running_loop().create_future()
        try:
            yield
        finally:
            del self._being_made[key, revision]
            done.set_result(None)

    async def _made_by_another(self, key: _Key, revision: Revision) -> _Kept | None:
        """Return what another call is just being answered with; None where there is none."""
        making = self._being_made.get((key, revision))
        if making is None:
            return None
        await asyncio.shield(making)
        return self._still_true(key, revision)

    def _still_true(self, key: _Key, revision: Revision) -> _Kept | None:
        kept = self._kept.get(key)
        if kept is None or time.monotonic() >= kept.until_s:
            return None
        if kept.made_of != revision.of(kept.made_of):
            return None
        self._kept.move_to_end(key)
        return kept

    def _keep(self, key: _Key, found: _Kept) -> None:
        if len(found.body) <= _LARGEST_BYTES:
            self._kept[key] = found
            self._kept.move_to_end(key)
        if len(self._kept) > _MOST:
            self._kept.popitem(last=False)


class _Answer:
    """A good answer as it goes by; `headers` stays None of any other."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self.headers: tuple[tuple[bytes, bytes], ...] | None = None
        self.body = bytearray()

    async def watched(self, message: Message) -> None:
        if message["type"] == "http.response.start" and message["status"] == 200:
            self.headers = tuple((bytes(name), bytes(value)) for name, value in message["headers"])
        elif self.headers is not None and len(self.body) <= _LARGEST_BYTES:
            self.body += message.get("body", b"")
        await self._send(message)


def _start(headers: tuple[tuple[bytes, bytes], ...]) -> Message:
    return {"type": "http.response.start", "status": 200, "headers": list(headers)}


def _key_of(scope: Scope) -> _Key | None:
    """Return what an answer depends on besides the store; None of calls that are not looked up."""
    if scope["type"] != "http" or scope["method"] != "GET":
        return None
    caller = scope.get("state", {}).get("caller")
    headers = Headers(scope=scope)
    if caller is None or _ASKS_FOR_LESS & set(headers):
        return None
    form = ",".join(headers.getlist("accept")), ",".join(headers.getlist("accept-encoding"))
    return scope["path"], scope["query_string"], form, frozenset(map(str, caller.scopes))
