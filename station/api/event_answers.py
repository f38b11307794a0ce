"""What comes out over HTTP of the events of a recording."""

from datetime import datetime
from typing import Self

from station.api.answers import Out
from station.operations import ListedEvent
from station.recording import LOSSES, EventKind
from station.viewing import moment


class EventModel(Out):
    """One thing that happened while a recording was made."""

    number: int
    """Its place among the events of the recording, from 1."""
    time: datetime
    """When it happened, by the station's clock."""
    kind: EventKind
    detail: str
    frame: int | None
    """The first frame concerned, as the camera numbers them."""
    count: int
    """How many frames, or packets, it concerns."""
    values: dict[str, float]
    """Numbers by name, where the kind has some."""
    loss: bool
    """Whether a recording with it is not complete."""

    @classmethod
    def of(cls, found: ListedEvent) -> Self:
        event = found.event
        return cls(
            number=found.number,
            time=datetime.fromisoformat(moment(event.time_ns)),
            kind=event.kind,
            detail=event.detail,
            frame=event.frame_id,
            count=event.count,
            values=dict(event.values),
            loss=event.kind in LOSSES,
        )


class EventsPage(Out):
    """Some events; `next` is the `after` of the next page, null on the last."""

    events: list[EventModel]
    next: int | None
