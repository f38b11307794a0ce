"""What was recorded."""

from datetime import datetime
from typing import Annotated

from fastapi import APIRouter, Query

from station.api.answers import RecordingModel, RecordingsPage
from station.api.callers import Reader
from station.api.parts import PartsOf
from station.api.requests import Limit, RecordingInPath
from station.errors import InputUnusable
from station.store import Recording, recordings_page, the

router = APIRouter(prefix="/v1/recordings", tags=["recordings"])


@router.get("")
def list_recordings(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Annotated[str | None, Query(max_length=256, description="`next` of a page.")] = None,
) -> RecordingsPage:
    """Return recordings, the newest first."""
    with parts.station.store.look() as session:
        page = recordings_page(session, limit=limit, before=_key(before))
    last = page.rows[-1] if page.more else None
    return RecordingsPage(
        recordings=[RecordingModel.of(row) for row in page.rows],
        next=f"{last.opened_at.isoformat()} {last.id}" if last else None,
    )


def _key(text: str | None) -> tuple[datetime, str] | None:
    if text is None:
        return None
    moment, _, recording_id = text.partition(" ")
    try:
        return datetime.fromisoformat(moment), recording_id
    except ValueError:
        raise InputUnusable(f"before {text!r}: send `next` of a page, as it came") from None


@router.get("/{recording_id}")
def get_recording(recording_id: RecordingInPath, parts: PartsOf, _: Reader) -> RecordingModel:
    """Return one recording and how its frames add up."""
    with parts.station.store.look() as session:
        return RecordingModel.of(the(session, Recording, recording_id))
