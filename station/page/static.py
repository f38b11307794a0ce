"""Styles and scripts; open to everybody, as they tell nothing of the station."""

from typing import Final

from fastapi import APIRouter, Request, Response

from station.errors import NotFound
from station.page.shell import ShellOf

router = APIRouter()
_FOR_GOOD: Final = "public, max-age=31536000, immutable"


@router.get("/static/{digest}/{name:path}")
async def get_static(digest: str, name: str, request: Request, shell: ShellOf) -> Response:
    """Return a file, by the digest of the version that the page was made with."""
    asset = shell.assets.files.get(name)
    if asset is None or digest != shell.assets.digest:
        raise NotFound("no such file; load the page anew")
    headers = {"Cache-Control": _FOR_GOOD, "Vary": "Accept-Encoding"}
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(asset.plain, media_type=asset.media_type, headers=headers)
    headers["Content-Encoding"] = "gzip"
    return Response(asset.packed, media_type=asset.media_type, headers=headers)
