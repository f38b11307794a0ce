"""The parts that the routes work with; `build_app` puts them together."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated

from fastapi import Depends, Request

from station.api.logins import Logins
from station.api.metrics import Metrics
from station.api.turns import Turns
from station.operations import Guiding, Passes, Sessions, Showing, Station, Uploads
from station.watching import Lookout


@dataclass(frozen=True, slots=True)
class Parts:
    """Everything a route may need."""

    station: Station
    passes: Passes
    sessions: Sessions
    uploads: Uploads
    metrics: Metrics
    worker_ready: Callable[[], bool]
    lookout: Lookout
    logins: Logins
    showing: Showing
    guiding: Guiding
    turns: Turns = field(default_factory=Turns)


async def _parts(request: Request) -> Parts:  # async: a plain one is called in another thread
    parts: Parts = request.app.state.parts
    names = getattr(request.state, "names", None)
    if names is None:
        return parts
    # What this call makes is named after the call: it may come again.
    return replace(parts, station=replace(parts.station, new_id=names))


PartsOf = Annotated[Parts, Depends(_parts)]
