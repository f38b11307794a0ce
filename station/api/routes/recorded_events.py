"""What happened while a recording was made: losses, interruptions, how frames were taken."""

from typing import Annotated

from fastapi import APIRouter, Query

from station.api.callers import Reader
from station.api.event_answers import EventModel, EventsPage
from station.api.parts import PartsOf
from station.api.requests import RecordingInPath
from station.operations import events_page

router = APIRouter(prefix="/v1/recordings/{recording_id}/events", tags=["recordings"])

_MOST_EVENTS = 10**9


@router.get("")
def list_events(
    recording_id: RecordingInPath,
    parts: PartsOf,
    _: Reader,
    limit: Annotated[int, Query(ge=1, le=1000, description="Rows of a page at most.")] = 100,
    after: Annotated[int, Query(ge=0, le=_MOST_EVENTS, description="`next` of a page.")] = 0,
) -> EventsPage:
    """Return the events of a closed recording in the order they were recorded."""
    found, more = events_page(parts.station, recording_id, after=after, limit=limit)
    return EventsPage(
        events=[EventModel.of(each) for each in found], next=found[-1].number if more else None
    )
