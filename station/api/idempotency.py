"""`Idempotency-Key`: a POST that comes again is answered again, and not done again.

As the draft of the IETF has it (draft-ietf-httpapi-idempotency-key-header): the same key with
another call is 422, while the first is being answered 409.  An answer is kept for a day, and only
where something was done: a refusal changed nothing, and the call may come again when it is allowed.
"""

import hashlib
import re
from typing import Final

from fastapi.concurrency import run_in_threadpool
from sqlalchemy.exc import IntegrityError
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.api.bodies import STREAMED, replaying, whole_body
from station.api.problems import problem_answer
from station.api.refusals import CallInProgress, IdempotencyKeyReused
from station.errors import InputUnusable, StationError
from station.operations import Station
from station.store import (
    Call,
    KeptAnswer,
    Standing,
    begin_call,
    forget_call,
    forget_unanswered,
    keep_answer,
)

HEADER: Final = "Idempotency-Key"
REPLAYED: Final = "Idempotency-Replayed"
_FORM = re.compile(r'"?([\x21\x23-\x7e]{1,255})"?')
_KEPT_HEADERS: Final = ("content-type", "location", "etag", "retry-after")


class Idempotency:
    """Middleware behind the guard: the key of a call is its caller's own."""

    def __init__(self, app: ASGIApp, station: Station) -> None:
        self._app = app
        self._store = station.store
        self._now = station.now
        with self._store.change() as session:
            forget_unanswered(session)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        key = Headers(scope=scope).get(HEADER) if _may_be_repeated(scope) else None
        if key is None:
            await self._app(scope, receive, send)
            return
        body = await whole_body(receive)
        try:
            call = _call(scope, key, body)
            kept = await run_in_threadpool(self._begin, call)
        except StationError as error:
            await problem_answer(scope["path"], error)(scope, receive, send)
            return
        if kept is not None:
            await _again(kept)(scope, receive, send)
            return
        answer = _Answer(send)
        done = False
        try:
            await self._app(scope, replaying(body, receive), answer.watched)
            done = 200 <= answer.status < 300
        finally:
            await run_in_threadpool(self._end, call, answer if done else None)
        # Only now: who has the answer and comes again must find it kept.
        await answer.give()

    def _begin(self, call: Call) -> KeptAnswer | None:
        """Return what is kept of a call; None where it is to be made."""
        try:
            with self._store.change() as session:
                standing, kept = begin_call(session, call, at=self._now())
        except IntegrityError:
            standing = Standing.RUNNING
        if standing is Standing.OF_ANOTHER_CALL:
            raise IdempotencyKeyReused(
                f"{HEADER} {call.key!r} came with another call before; give each call its own"
            )
        if standing is Standing.RUNNING:
            raise CallInProgress(f"the call with {HEADER} {call.key!r} is being answered; wait")
        return kept if standing is Standing.ANSWERED else None

    def _end(self, call: Call, answer: "_Answer | None") -> None:
        with self._store.change() as session:
            if answer is None:
                forget_call(session, call)
            else:
                keep_answer(
                    session,
                    call,
                    status=answer.status,
                    headers=answer.headers,
                    body=answer.body,
                )


class _Answer:
    """An answer as it is given, held back until it is kept."""

    def __init__(self, send: Send) -> None:
        self._send = send
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

    async def give(self) -> None:
        for message in self._messages:
            await self._send(message)


def _may_be_repeated(scope: Scope) -> bool:
    # An upload is known again by its bytes.
    return (
        scope["type"] == "http"
        and scope["method"] == "POST"
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


def _again(kept: KeptAnswer) -> Response:
    headers = {**(kept.headers or {}), REPLAYED: "true"}
    return Response(kept.body, status_code=kept.status or 200, headers=headers)
