"""The parts that the routes work with; `build_app` puts them together."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request

from station.api.metrics import Metrics
from station.operations import Passes, Sessions, Station, Uploads


@dataclass(frozen=True, slots=True)
class Parts:
    """Everything a route may need."""

    station: Station
    passes: Passes
    sessions: Sessions
    uploads: Uploads
    metrics: Metrics
    worker_ready: Callable[[], bool]


def _parts(request: Request) -> Parts:
    parts: Parts = request.app.state.parts
    return parts


PartsOf = Annotated[Parts, Depends(_parts)]
