"""The addresses of the list and of each recording."""

from functools import partial
from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Query, Request, Response

from station.api import By, Calibrator, PartsOf, Reader
from station.operations import events_page
from station.page.recordings.contents import contents, moment_of
from station.page.recordings.list_view import recording_list
from station.page.recordings.recording_view import recording_page, wheel_frames
from station.page.recordings.search import Search
from station.page.shell import ShellOf
from station.recording import LOSSES
from station.store.recordings_found import RecordingKind

router = APIRouter()

_MOST_EVENTS = 200


@router.get("/recordings")
def get_page(
    request: Request, shell: ShellOf, parts: PartsOf, _: Reader, search: Annotated[Search, Query()]
) -> Response:
    """Return the list."""
    return shell.page(
        request,
        "recordings/index.html",
        active="recordings",
        search=search,
        found=recording_list(parts.station, search),
        sensors=sorted(each.id for each in parts.station.settings.sensors),
        kinds=tuple(RecordingKind),
        upload_mb=parts.station.settings.web.upload_mb,
    )


@router.get("/recordings/{recording_id}")
def get_recording(
    recording_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Reader
) -> Response:
    """Return the page of a recording."""
    shown = recording_page(parts.station, recording_id)
    return shell.page(request, "recordings/recording.html", active="recordings", shown=shown)


@router.get("/recordings/{recording_id}/contents")
def get_contents(
    recording_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Reader
) -> Response:
    """Return what the recording's file says of itself, a part of its page."""
    said = contents(parts.station, recording_id)
    return shell.page(request, "recordings/contents.html", said=said)


@router.get("/recordings/{recording_id}/timeline")
async def get_timeline(recording_id: str, parts: PartsOf, _: Reader) -> Response:
    """Return how frames, events and wheels lie in time, as JSON; it is made elsewhere."""
    frames = await to_thread.run_sync(partial(_wheel_frames, parts, recording_id))
    show = partial(parts.showing.timeline, recording_id, frames)
    view = (await parts.turns.take(None, show)).view
    return Response(view.content, media_type=view.form.media_type)


@router.get("/recordings/{recording_id}/events")
def get_events(
    recording_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Reader
) -> Response:
    """Return what happened while it was recorded, a part of the page of one without frames."""
    found, more = events_page(parts.station, recording_id, after=0, limit=_MOST_EVENTS)
    events = [(moment_of(each.event), each.event) for each in found]
    return shell.page(request, "recordings/events.html", events=events, more=more, losses=LOSSES)


@router.post("/recordings/{recording_id}/delete")
def post_delete(
    recording_id: str, shell: ShellOf, parts: PartsOf, _: Calibrator, by: By
) -> Response:
    """Delete an uploaded recording."""
    parts.uploads.remove(recording_id, by)
    said = shell.texts.say("recordings.deleting.done", id=recording_id)
    return shell.done(said, to="/recordings")


def _wheel_frames(parts: PartsOf, recording_id: str) -> list[int]:
    with parts.station.store.look() as session:
        return wheel_frames(session, recording_id)
