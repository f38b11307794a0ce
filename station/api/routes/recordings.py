"""What was recorded."""

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import FileResponse

from station.api.actors import By
from station.api.answers import RecordingModel
from station.api.callers import Calibrator, Reader
from station.api.list_answers import RecordingsPage
from station.api.paging import Before, Since, Until, cursor_in, span_of
from station.api.parts import PartsOf
from station.api.receiving import receive_upload
from station.api.remembered import from_the_store
from station.api.requests import CallersId, Limit, RecordingInPath
from station.operations import recording_file
from station.settings import SensorId
from station.store import Recording, the
from station.store.lists import recordings_page

router = APIRouter(prefix="/v1/recordings", tags=["recordings"])


@router.get("")
@from_the_store
def list_recordings(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    sensor: SensorId | None = None,
    pass_id: Annotated[CallersId | None, Query(alias="pass")] = None,
    session_id: Annotated[
        CallersId | None, Query(alias="session", description="A calibration session.")
    ] = None,
    since: Since = None,
    until: Until = None,
) -> RecordingsPage:
    """Return recordings, the newest first."""
    with parts.station.store.look() as session:
        page = recordings_page(
            session,
            limit=limit,
            before=cursor_in(before),
            span=span_of(since, until),
            sensor=sensor,
            pass_id=pass_id,
            session_id=session_id,
        )
    return RecordingsPage.of(page)


@router.get("/{recording_id}")
@from_the_store
def get_recording(recording_id: RecordingInPath, parts: PartsOf, _: Reader) -> RecordingModel:
    """Return one recording and how its frames add up."""
    with parts.station.store.look() as session:
        return RecordingModel.of(the(session, Recording, recording_id))


@router.get(
    "/{recording_id}/files/{number}",
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}}},
)
def get_file(
    recording_id: RecordingInPath,
    number: Annotated[int, Path(ge=1, le=100_000, description="From 1 to `files`.")],
    parts: PartsOf,
    _: Reader,
) -> FileResponse:
    """Return a file of a recording (MCAP), or the part of it that a Range header names."""
    return FileResponse(
        recording_file(parts.station, recording_id, number),
        media_type="application/octet-stream",
        filename=f"{recording_id}.{number}.mcap",
    )


@router.post(
    "",
    status_code=201,
    responses={200: {"model": RecordingModel, "description": "It was uploaded before."}},
    openapi_extra={
        "requestBody": {
            "required": True,
            "description": "The file as it is; its Content-Length must be given.",
            "content": {"application/octet-stream": {"schema": {"type": "string"}}},
        }
    },
)
async def post_recording(
    request: Request, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> RecordingModel:
    """Take in a recording (MCAP) of one sensor; the same bytes a second time are the same one."""
    row, new = await receive_upload(request, parts, by)
    response.status_code = 201 if new else 200
    response.headers["Location"] = f"/v1/recordings/{row.id}"
    return RecordingModel.of(row)


@router.delete("/{recording_id}")
def delete_recording(
    recording_id: RecordingInPath, parts: PartsOf, _: Calibrator, by: By
) -> RecordingModel:
    """Delete an uploaded recording; what was measured from it stays."""
    return RecordingModel.of(parts.uploads.remove(recording_id, by))
