"""Serves the API and the pages of a copy of the demo station's data: one process, no cameras.

Run as `demo_station_quiet.py FOLDER FILMS`; it prints one JSON document with the URL.
"""

import json
import socket
import sys
from itertools import cycle, islice
from pathlib import Path

import cv2
import uvicorn
from demo_station_capture import Exposure
from demo_station_desk import Desk
from demo_station_pictures import Pictures
from demo_station_story import OPERATOR
from demo_station_truth import RIGHT
from demo_station_worker import HostClock

from station.api import build_app
from station.host_clock import ClockState
from station.logs import log_as
from station.page import add_pages
from station.serve.web import server_config
from station.settings import load_settings

LIVE_SESSION, LIVE_PICTURES = "right-today", 7
_FURTHER = 500
"""Pictures that a camera has left for who looks through it, or presses the button."""


def main(folder: Path, films: Path) -> None:
    """Serve until this process is told to end."""
    log_as("api")
    cv2.setNumThreads(1)
    settings = load_settings(folder / "station.toml")
    desk = Desk(settings, Pictures.of_films(films), HostClock())
    _open_session(desk)
    app = build_app(desk.station, admin_key=None, worker_ready=lambda: True)
    # Whether this host's clock is kept is not what the pages are looked at for.
    app.state.parts.lookout._clock = lambda: ClockState(True, 0.01)
    add_pages(app)
    listening = socket.create_server((settings.host, settings.port))
    url = f"http://{settings.host}:{listening.getsockname()[1]}"
    # Who connects from now on is answered once the server runs.
    print(json.dumps({"url": url}, indent=2), flush=True)
    uvicorn.Server(server_config(app, settings)).run(sockets=[listening])
    desk.store.close()


def _open_session(desk: Desk) -> None:
    pictures = desk.pictures.targets
    shown = {RIGHT: pictures[RIGHT][:LIVE_PICTURES]}
    desk.session(LIVE_SESSION, shown, by=OPERATOR, finish=False)
    for sensor, film in desk.films.items():
        film.show(Exposure(picture) for picture in islice(cycle(pictures[sensor]), _FURTHER))


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:]))
