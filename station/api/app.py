"""Assembling the API."""

from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI
from starlette.types import Lifespan

from station.api.bodies import Bodies
from station.api.contract import contract_of
from station.api.gate import Gate
from station.api.guard import Guard
from station.api.idempotency import Idempotency
from station.api.logins import Logins
from station.api.metrics import Metrics
from station.api.parts import Parts
from station.api.problems import PROBLEMS, answer_with_problems
from station.api.remembered import Remembered
from station.api.routes import ROUTERS
from station.api.watch import Watch
from station.guiding import Guide
from station.operations import Guiding, Passes, Sessions, Showing, Station, Uploads
from station.viewing import Viewer
from station.watching import Lookout

API_VERSION = "1.5.0"


def build_app(
    station: Station, *, admin_key: str | None, worker_ready: Callable[[], bool]
) -> FastAPI:
    """Return the API of a station.

    Raises
    ------
    InputUnusable
        If `admin_key` is too short.
    """
    lookout = Lookout(station, worker_ready)
    metrics, gate, uploads = Metrics(station, lookout), Gate(station, admin_key), Uploads(station)
    uploads.take_up()
    viewer = Viewer(station.settings.log_level, station.layout.processes_lock)
    guide = Guide(station.settings.log_level, station.layout.processes_lock)
    app = _with_routes(_closing(viewer, guide))
    app.state.parts = Parts(
        station=station,
        passes=Passes(station),
        sessions=Sessions(station),
        uploads=uploads,
        metrics=metrics,
        worker_ready=worker_ready,
        lookout=lookout,
        logins=Logins(station, gate),
        showing=Showing(station, viewer),
        guiding=Guiding(station, guide),
    )
    answer_with_problems(app)
    # The last one added is the first a call meets.
    app.add_middleware(Idempotency, station=station)
    app.add_middleware(Bodies, web=station.settings.web)
    app.add_middleware(Remembered, store=station.store)
    app.add_middleware(Guard, gate=gate)
    app.add_middleware(Watch, metrics=metrics)
    return app


def contract() -> dict[str, Any]:
    """Return the contract of the API, which is the same for every station, as OpenAPI."""
    return contract_of(_with_routes())


def _closing(viewer: Viewer, guide: Guide) -> Lifespan[FastAPI]:
    """Have what it started end with the app, where that ends before its own process."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncGenerator[None]:
        yield
        viewer.close()
        guide.close()

    return lifespan


def _with_routes(lifespan: Lifespan[FastAPI] | None = None) -> FastAPI:
    app = FastAPI(
        lifespan=lifespan,
        title="Treadline station",
        version=API_VERSION,
        description="Measures railway wheels with laser light.\n\n"
        "A call carries a key as a bearer token. A browser that has logged in at `/login` carries "
        "its cookie instead, and `X-CSRF-Token` besides with every call that is not GET; the "
        "station's own pages know it.",
        # The framework's own pages load their scripts from a CDN, and are open to everybody.
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
    )
    for router in ROUTERS:
        app.include_router(router, responses=PROBLEMS)
    return app
