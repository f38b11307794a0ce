"""Looking into a recording, frame by frame."""

from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Path, Query, Response

from station.api.callers import Reader
from station.api.frame_answers import FrameModel, FramesPage
from station.api.parts import PartsOf
from station.api.requests import RecordingInPath
from station.operations import frame_as_png, frames_page

router = APIRouter(prefix="/v1/recordings/{recording_id}/frames", tags=["recordings"])

_MOST_FRAMES = 10**9
_PNG = "image/png"


@router.get("")
def list_frames(
    recording_id: RecordingInPath,
    parts: PartsOf,
    _: Reader,
    limit: Annotated[int, Query(ge=1, le=200, description="Rows of a page at most.")] = 100,
    after: Annotated[int, Query(ge=0, le=_MOST_FRAMES, description="`next` of a page.")] = 0,
) -> FramesPage:
    """Return the frames of a closed recording in the order they were recorded."""
    found, more = frames_page(parts.station, recording_id, after=after, limit=limit)
    return FramesPage(
        frames=[FrameModel.of(each) for each in found], next=found[-1].number if more else None
    )


@router.get("/{number}/picture", response_class=Response, responses={200: {"content": {_PNG: {}}}})
async def get_picture(
    recording_id: RecordingInPath,
    number: Annotated[int, Path(ge=1, le=_MOST_FRAMES, description="From 1, in the list.")],
    parts: PartsOf,
    _: Reader,
    max_width: Annotated[
        int | None, Query(ge=16, le=16_384, description="In pixels; a wider one is made smaller.")
    ] = None,
) -> Response:
    """Return one frame of a closed recording as a picture (PNG)."""

    def png() -> bytes:
        return frame_as_png(parts.station, recording_id, number, max_width=max_width)

    # Whoever waits here holds no thread.
    content = await to_thread.run_sync(png, limiter=parts.looking)
    return Response(content, media_type=_PNG)
