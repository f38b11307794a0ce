"""`Idempotency-Key`: a POST that comes again is answered again, and not done again.

As the draft of the IETF has it (draft-ietf-httpapi-idempotency-key-header): the same key with
another call is 422, while the first is being answered 409.  An answer is kept for a day, and only
where something was done: a refusal changed nothing, and the call may come again when it is allowed.

A call that was never answered, as the process died or failed, may have been done.  It is made once
more, and what it makes has the same names as then: so it finds what is there, and makes the rest.
"""

import hashlib
import re
from threading import Lock
from typing import Final

from fastapi.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.api.bodies import STREAMED, replaying, whole_body
from station.api.call_names import CallNames
from station.api.problems import problem_answer
from station.api.refusals import CallInProgress, IdempotencyKeyReused
from station.errors import InputUnusable, StationError
from station.operations import Station
from station.store import KeptAnswer
from station.store.callers import Call, Standing, begin_call, forget_call, keep_answer

HEADER: Final = "Idempotency-Key"
REPLAYED: Final = "Idempotency-Replayed"
_FORM = re.compile(r'"?([\x21\x23-\x7e]{1,255})"?')
_PROGRAMS: Final = "/v1/"
_REFUSED, _FAILED = 300, 500
_KEPT_HEADERS: Final = ("content-type", "location", "etag", "retry-after")


class Idempotency:
    """Middleware behind the guard: the key of a call is its caller's own."""

    def __init__(self, app: ASGIApp, station: Station) -> None:
        self._app = app
        self._store = station.store
        self._now = station.now
        self._running: dict[tuple[str, str], str] = {}
        """Fingerprints of the calls that are being answered, by caller and key."""
        self._lock = Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        key = Headers(scope=scope).get(HEADER) if _may_be_repeated(scope) else None
        if key is None:
            await self._app(scope, receive, send)
            return
        body = await whole_body(receive)
        try:
            call = _call(scope, key, body)
            self._take(call)
        except StationError as error:
            await problem_answer(scope["path"], error)(scope, receive, send)
            return
        try:
            given = await self._answered(call, scope, replaying(body, receive), send)
        except StationError as error:
            # The store did not let the call be noted, or its answer be kept: it may come again.
            given = problem_answer(scope["path"], error)
        finally:
            self._release(call)
        # Only now: who has the answer and comes again must find it kept.
        await given(scope, receive, send)

    async def _answered(self, call: Call, scope: Scope, receive: Receive, send: Send) -> ASGIApp:
        """Return the answer to a call, made now or kept from before."""
        standing, kept = await run_in_threadpool(self._begin, call)
        if standing is Standing.OF_ANOTHER_CALL:
            raise _reused(call)
        if standing is Standing.ANSWERED:
            return _again(kept)
        scope["state"]["names"] = CallNames(call, kept.asked_at)
        answer = _Answer()
        await self._app(scope, receive, answer.watched)
        if answer.status < _FAILED:
            await run_in_threadpool(self._end, call, answer)
        return answer.give

    def _take(self, call: Call) -> None:
        """Let a call be answered once at a time."""
        with self._lock:
            running = self._running.get((call.caller, call.key))
            if running is None:
                self._running[call.caller, call.key] = call.fingerprint
                return
        if running != call.fingerprint:
            raise _reused(call)
        raise CallInProgress(f"the call with {HEADER} {call.key!r} is being answered; wait")

    def _release(self, call: Call) -> None:
        with self._lock:
            del self._running[call.caller, call.key]

    def _begin(self, call: Call) -> tuple[Standing, KeptAnswer]:
        with self._store.change() as session:
            return begin_call(session, call, at=self._now())

    def _end(self, call: Call, answer: "_Answer") -> None:
        """Keep an answer to what was done; of a refusal nothing is kept."""
        with self._store.change() as session:
            if answer.status >= _REFUSED:
                forget_call(session, call)
                return
            keep_answer(
                session, call, status=answer.status, headers=answer.headers, body=answer.body
            )


class _Answer:
    """An answer as it is given, held back until it is kept."""

    def __init__(self) -> None:
        self._messages: list[Message] = []
        self.status = 500
        self.headers: dict[str, str] = {}

    async def watched(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.status = message["status"]
            found = MutableHeaders(scope=message)
            self.headers = {name: found[name] for name in _KEPT_HEADERS if name in found}
        self._messages.append(message)

    @property
    def body(self) -> bytes:
        return b"".join(message.get("body", b"") for message in self._messages)

    async def give(self, _scope: Scope, _receive: Receive, send: Send) -> None:
        for message in self._messages:
            await send(message)


def _may_be_repeated(scope: Scope) -> bool:
    # An upload is known again by its bytes; the answer to a button of a page may hold a new key,
    # which is kept nowhere.
    return (
        scope["type"] == "http"
        and scope["method"] == "POST"
        and scope["path"].startswith(_PROGRAMS)
        and (scope["method"], scope["path"]) not in STREAMED
        and "caller" in scope.get("state", {})
    )


def _call(scope: Scope, key: str, body: bytes) -> Call:
    form = _FORM.fullmatch(key.strip())
    if form is None:
        raise InputUnusable(
            f"{HEADER} of {len(key)} characters: 1 to 255 letters, digits or signs, no spaces"
        )
    place = f"{scope['method']} {scope['path']}?{scope['query_string'].decode('latin-1')}\n"
    fingerprint = hashlib.sha256(place.encode() + body).hexdigest()
    return Call(scope["state"]["caller"].name, form[1], fingerprint)


def _reused(call: Call) -> IdempotencyKeyReused:
    return IdempotencyKeyReused(
        f"{HEADER} {call.key!r} came with another call before; give each call its own"
    )


def _again(kept: KeptAnswer) -> Response:
    headers = {**(kept.headers or {}), REPLAYED: "true"}
    return Response(kept.body, status_code=kept.status or 200, headers=headers)
