"""Receiving an upload piece by piece, so that its size costs disk and never memory."""

import asyncio
from collections.abc import AsyncIterator

from fastapi import Request
from fastapi.concurrency import run_in_threadpool

from station.api.bodies import pieces_of
from station.api.parts import Parts
from station.api.refusals import BodyRefused, BodyTooSlow
from station.operations import Upload
from station.store import Actor, Recording

_PIECE_BYTES = 1 << 20


async def receive_upload(request: Request, parts: Parts, by: Actor) -> tuple[Recording, bool]:
    """Return the recording that a call brings, and whether it is new.

    Raises
    ------
    BodyRefused
        If it does not say how long it is, or does not come as it says.
    """
    said = request.headers.get("Content-Length", "")
    if not (said.isascii() and said.isdigit()):
        raise BodyRefused("an upload says its length before; send Content-Length")
    upload = await run_in_threadpool(parts.uploads.begin, int(said[:19]))
    try:
        patience_s = parts.station.settings.web.body_s
        async for piece in _larger(_patiently(request, upload, patience_s)):
            await run_in_threadpool(upload.take, piece)
        return await run_in_threadpool(parts.uploads.finish, upload, by)
    finally:
        # Shielded by nothing: it is quick, and does nothing after the end.
        parts.uploads.abandon(upload)


async def _patiently(request: Request, upload: Upload, patience_s: float) -> AsyncIterator[bytes]:
    pieces = pieces_of(request.headers, request.receive, upload.size_bytes)
    while True:
        try:
            async with asyncio.timeout(patience_s):
                piece = await anext(pieces, None)
        except TimeoutError:
            raise BodyTooSlow(
                f"nothing of the upload came for {patience_s:g} s; send it again"
            ) from None
        if piece is None:
            return
        yield piece


async def _larger(pieces: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """Yield pieces of a megabyte: a thread for each of the network's would cost more than it."""
    gathered = bytearray()
    async for piece in pieces:
        gathered += piece
        if len(gathered) >= _PIECE_BYTES:
            yield bytes(gathered)
            gathered.clear()
    if gathered:
        yield bytes(gathered)
