"""Assembling the API."""

from collections.abc import Callable

from fastapi import FastAPI

from station.api.gate import Gate
from station.api.guard import Guard
from station.api.metrics import Metrics
from station.api.parts import Parts
from station.api.problems import PROBLEMS, answer_with_problems
from station.api.routes import ROUTERS
from station.api.watch import Watch
from station.operations import Passes, Sessions, Station

API_VERSION = "1.1.0"


def build_app(
    station: Station, *, admin_key: str | None, worker_ready: Callable[[], bool]
) -> FastAPI:
    """Return the API of a station.

    Raises
    ------
    InputUnusable
        If `admin_key` is too short.
    """
    metrics, gate = Metrics(station), Gate(station, admin_key)
    app = FastAPI(
        title="Treadline station",
        version=API_VERSION,
        description="Measures railway wheels with laser light.",
        # The framework's own pages load their scripts from a CDN, and are open to everybody.
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
    )
    app.state.parts = Parts(
        station=station,
        passes=Passes(station),
        sessions=Sessions(station),
        metrics=metrics,
        worker_ready=worker_ready,
    )
    answer_with_problems(app)
    app.add_middleware(Guard, gate=gate)
    app.add_middleware(Watch, metrics=metrics)
    for router in ROUTERS:
        app.include_router(router, responses=PROBLEMS)
    return app
