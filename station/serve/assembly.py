"""Putting the parts of the API process together from the settings."""

import threading
from functools import partial
from pathlib import Path

from fastapi import FastAPI

from station.api import build_app
from station.capture import CaptureClient
from station.operations import (
    DataLayout,
    Lifetimes,
    Passes,
    Sessions,
    Station,
    salvage_recording,
)
from station.page import add_pages
from station.serve.looking import begin_looking
from station.serve.sockets import socket_path
from station.settings import StationSettings
from station.store import Store
from station.worker import WorkerQueue, is_held

_CAPTURE_START_S = 3.0
"""A capture process started again listens within a second; a caller waits for it so long."""


def assemble_api(settings: StationSettings, run_dir: Path, *, admin_key: str | None) -> FastAPI:
    """Return the API and the pages on the station's own store, captures and worker.

    Passes and sessions that were open when the last API process ended are taken up first.
    """
    layout = DataLayout.of(settings)
    station = Station(
        settings=settings,
        store=Store.open(layout.store_url),
        layout=layout,
        captures={
            sensor.id: CaptureClient(
                socket_path(run_dir, sensor.id), connect_timeout_s=_CAPTURE_START_S
            )
            for sensor in settings.sensors
        },
        jobs=WorkerQueue(layout.jobs_url),
        salvage=salvage_recording,
    )
    Passes(station).take_up()
    Sessions(station).take_up()
    app = build_app(station, admin_key=admin_key, worker_ready=partial(is_held, layout.worker_lock))
    add_pages(app)
    # With the desks of the API, whose locks keep a time-out and a finish apart.  It ends with the
    # process: what it is at then is taken up at the next start.
    lifetimes = Lifetimes(station, app.state.parts.passes, app.state.parts.sessions)
    begin_looking(lifetimes.look, threading.Event())
    return app
