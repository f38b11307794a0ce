"""The body of a call: taken whole, in its size and its time, and looked at before it is used."""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any, Final, NoReturn

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from station.api.problems import problem_answer
from station.api.refusals import BodyRefused, BodyTooLarge, BodyTooSlow
from station.settings import WebSettings

STREAMED: Final = frozenset({("POST", "/v1/recordings")})
"""Calls that read their body themselves, piece by piece, by `pieces_of`."""
_READS: Final = frozenset({"GET", "HEAD"})
_LENGTHS: Final = frozenset({"content-length", "transfer-encoding"})
_DEEPEST: Final = 32
_TWO_LENGTHS: Final = (
    "the call has both Content-Length and Transfer-Encoding, "
    "its body can be read in two ways; send one of them"
)
KB: Final = 1000


class Bodies:
    """Middleware that hands on a call only once its body is there and fit to be read."""

    def __init__(self, app: ASGIApp, web: WebSettings) -> None:
        self._app = app
        self._most_bytes = web.body_kb * KB
        self._within_s = web.body_s

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or (scope["method"], scope["path"]) in STREAMED:
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if scope["method"] in _READS and not _LENGTHS & set(headers):
            await self._app(scope, receive, send)  # it says that it has none
            return
        if "Content-Length" in headers and "Transfer-Encoding" in headers:
            answer = problem_answer(scope["path"], BodyRefused(_TWO_LENGTHS))
            # Where one server ends the body, another reads the next call: nothing more is read.
            answer.headers["Connection"] = "close"
            await answer(scope, receive, send)
            return
        try:
            async with asyncio.timeout(self._within_s):
                pieces = pieces_of(headers, receive, self._most_bytes)
                body = b"".join([piece async for piece in pieces])
            if body and "json" in headers.get("Content-Type", "").lower():
                ensure_fit(body)
        except TimeoutError:
            too_slow = BodyTooSlow(f"the body was not whole after {self._within_s:g} s; send again")
            await problem_answer(scope["path"], too_slow)(scope, receive, send)
        except BodyRefused as error:
            await problem_answer(scope["path"], error)(scope, receive, send)
        else:
            await self._app(scope, replaying(body, receive), send)


async def pieces_of(headers: Headers, receive: Receive, most_bytes: int) -> AsyncIterator[bytes]:
    """Yield the body of a call piece by piece.

    Raises
    ------
    BodyTooLarge
        If it says that it is larger than allowed, or is.
    BodyRefused
        If the caller goes away before its end.
    """
    said = headers.get("Content-Length", "0")
    if not (said.isascii() and said.isdigit() and int(said[:19]) <= most_bytes):
        raise _too_large(most_bytes)
    taken, more = 0, True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise BodyRefused("the body broke off before its end; send the call again")
        piece: bytes = message.get("body", b"")
        taken, more = taken + len(piece), message.get("more_body", False)
        if taken > most_bytes:
            raise _too_large(most_bytes)
        yield piece


async def whole_body(receive: Receive) -> bytes:
    """Return the body of a call that came through `Bodies`, which is one piece."""
    message = await receive()
    body: bytes = message["body"]
    return body


def _too_large(most_bytes: int) -> BodyTooLarge:
    return BodyTooLarge(f"the body may have {most_bytes} bytes at most; send less")


def replaying(body: bytes, receive: Receive) -> Receive:
    """Return a `receive` that gives the body first, and then what the server has to tell."""
    given = False

    async def replay() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return replay


def ensure_fit(body: bytes) -> None:
    """Refuse JSON that is not UTF-8, cannot be read in one way only, or is nested too deeply.

    Raises
    ------
    BodyRefused
        With what is wrong.
    """
    if not body:
        return
    try:
        value = json.loads(body.decode(), parse_constant=_no_such_number, object_pairs_hook=_once)
    except UnicodeDecodeError as error:
        raise BodyRefused(f"the body is not UTF-8 (byte {error.start}); send it as UTF-8") from None
    except RecursionError:
        raise _too_deep() from None
    except json.JSONDecodeError:
        return  # whoever reads the body says where
    except ValueError as error:
        # Numbers of thousands of digits.
        raise BodyRefused(f"the body is not JSON that can be read: {error}") from None
    if _depth(value) > _DEEPEST:
        raise _too_deep()


def _too_deep() -> BodyRefused:
    return BodyRefused(f"the body is nested deeper than {_DEEPEST}; send it flatter")


def _once(fields: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object whose every name is there once: of two, each reader takes another."""
    found = dict(fields)
    if len(found) < len(fields):
        names = [name for name, _ in fields]
        twice = next(name for name in names if names.count(name) > 1)
        raise BodyRefused(f"the body has {twice[:64]!r} twice in one object; give it once")
    return found


def _no_such_number(name: str) -> NoReturn:
    raise BodyRefused(f"the body holds {name}, which is no number of JSON; leave it out")


def _depth(value: Any) -> int:
    """Return how deeply lists and objects are nested, or one more than allowed.

    >>> _depth(1), _depth([]), _depth({"a": [1]})
    (0, 1, 2)
    """
    depth, level = 0, [value]
    while depth <= _DEEPEST:
        holders = [each for each in level if isinstance(each, list | dict)]
        if not holders:
            return depth
        depth += 1
        level = [
            inner
            for each in holders
            for inner in (each.values() if isinstance(each, dict) else each)
        ]
    return depth
