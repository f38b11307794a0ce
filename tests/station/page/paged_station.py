"""The pages and the API of a station without a past, in this process; cameras are doubles."""

import re
import shutil
import socket
import threading
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import httpx
import uvicorn

from station.api import CSRF_HEADER, LoggedIn, build_app
from station.capture import CaptureState, CaptureStatus
from station.errors import CameraLost
from station.operations import DataLayout, Keys, Station, salvage_recording, utc_now
from station.page import add_pages
from station.serve.web import server_config
from station.settings import StationSettings
from station.store import Actor, Store
from station.store.callers import Scope

ENVIRONMENT_KEY = "a-key-of-the-environment-of-32-or-more-letters"
PASSWORD = "hunter2-of-the-database"
SENSORS = (
    {"id": "left", "address": "127.47.1.1", "exposure_us": 500.0, "packet_size": 9000},
    {"id": "right", "address": "127.47.1.2", "side": "right"},
)
_TOKEN = re.compile(r'name="csrf-token" content="([0-9a-f]{64})"')
_NUMBERS = count(1)
PEOPLE = {"Accept": "text/html,application/xhtml+xml"}


@dataclass
class CameraDouble:
    """A capture process that tells what it is told to; None: it does not answer."""

    sensor: str
    camera: dict[str, str] | None = field(default_factory=dict)

    def status(self):
        if self.camera is None:
            raise CameraLost(f"the capture process of {self.sensor} does not answer")
        return CaptureStatus(CaptureState.IDLE, self.sensor, camera=self.camera)


@dataclass
class QueueDouble:
    submitted: list = field(default_factory=list)

    def submit(self, kind, job_id):
        self.submitted.append((kind.value, job_id))

    def cancel(self, job_id):
        pass


class Paged:
    """A station that is served with its pages."""

    def __init__(self, root: Path, empty_store: Path, **settings) -> None:
        self.settings = StationSettings(data_dir=root, sensors=SENSORS, **settings)
        layout = DataLayout.of(self.settings)
        shutil.copy(empty_store, layout.store_file)
        self.store = Store.open(layout.store_url)
        self.queue = QueueDouble()
        self.captures = {sensor.id: CameraDouble(sensor.id) for sensor in self.settings.sensors}
        self.station = Station(
            settings=self.settings,
            store=self.store,
            layout=layout,
            captures=self.captures,
            jobs=self.queue,
            salvage=salvage_recording,
        )
        self.begin(ENVIRONMENT_KEY)

    def begin(self, environment_key: str | None) -> None:
        """Begin to serve, as a new API process does."""
        self.app = build_app(self.station, admin_key=environment_key, worker_ready=lambda: True)
        add_pages(self.app)
        listening = socket.create_server(("127.0.0.1", 0))
        self.host = f"127.0.0.1:{listening.getsockname()[1]}"
        self.url = f"http://{self.host}"
        self._server = uvicorn.Server(server_config(self.app, self.settings))
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [listening]}, daemon=True
        )
        self._thread.start()

    def end(self) -> None:
        """Serve no more."""
        self._server.should_exit = True
        self._thread.join(30.0)

    def close(self) -> None:
        self.end()
        self.store.close()

    @property
    def keys(self) -> Keys:
        return Keys(self.store, Actor("test"), utc_now())

    def key(self, *scopes: Scope, name: str | None = None) -> str:
        """Make a key of somebody who has none."""
        return self.keys.create(name or f"somebody {next(_NUMBERS)}", scopes, None)

    def client(self, **headers: str) -> httpx.Client:
        """Return a program that has no key, or that of its headers."""
        return httpx.Client(base_url=self.url, headers=headers, timeout=30.0, trust_env=False)

    @contextmanager
    def browser(self, key: str | None = None) -> Generator[httpx.Client]:
        """Open a browser; where a key is given, logged in, its calls vouched for."""
        with self.client(**PEOPLE) as browser:
            if key is not None:
                cookie = log_in(browser, key).cookies["treadline"]
                browser.headers[CSRF_HEADER] = LoggedIn(cookie).csrf_token
            yield browser


def log_in(browser: httpx.Client, key: str) -> httpx.Response:
    """Send the form of the login."""
    return browser.post("/login", data={"key": key}, headers={"Origin": str(browser.base_url)})


def token_of(browser: httpx.Client) -> str:
    """Return what the pages of a browser vouch for its calls with."""
    found = _TOKEN.search(browser.get("/set-up").text)
    assert found is not None, "this browser is not logged in"
    return found[1]
