"""Looking into a recording, frame by frame."""

from functools import partial
from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query, Response

from station.api.callers import Reader
from station.api.frame_answers import FrameModel, FramesPage
from station.api.parts import PartsOf
from station.api.requests import RecordingInPath
from station.api.view_answers import FrameStripeModel, answer_for_good
from station.operations import frames_page
from station.viewing import Form

router = APIRouter(prefix="/v1/recordings/{recording_id}/frames", tags=["recordings"])

_MOST_FRAMES = 10**9
NumberInPath = Annotated[int, Path(ge=1, le=_MOST_FRAMES, description="From 1, in the list.")]


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


@router.get(
    "/{number}/picture",
    response_class=Response,
    responses={200: {"content": {form.media_type: {} for form in (Form.PNG, Form.JPEG)}}},
)
async def get_picture(
    recording_id: RecordingInPath,
    number: NumberInPath,
    parts: PartsOf,
    _: Reader,
    max_width: Annotated[
        int | None, Query(ge=16, le=16_384, description="In pixels; a wider one is made smaller.")
    ] = None,
    form: Annotated[
        Literal[Form.PNG, Form.JPEG],
        Query(alias="format", description="PNG is exact, JPEG a fifth as large."),
    ] = Form.PNG,
) -> Response:
    """Return one frame of a closed recording as a picture."""
    show = partial(parts.showing.frame, recording_id, number, form, max_width=max_width)
    return answer_for_good(await parts.turns.take(None, show))


@router.get(
    "/{number}/stripe", response_class=Response, responses={200: {"model": FrameStripeModel}}
)
async def get_stripe(
    recording_id: RecordingInPath, number: NumberInPath, parts: PartsOf, _: Reader
) -> Response:
    """Return the stripe found on one frame of a closed recording, its brightness and focus."""
    show = partial(parts.showing.frame, recording_id, number, Form.STRIPE, max_width=None)
    return answer_for_good(await parts.turns.take(None, show))
