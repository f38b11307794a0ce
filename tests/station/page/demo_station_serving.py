"""The demo station served: by all its processes before simulated cameras, or by its API alone."""

import json
import os
import secrets
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path

import httpx
import uvicorn
from demo_station_cameras import DemoCameras
from demo_station_capture import Exposure
from demo_station_data import SEED, DemoData
from demo_station_desk import Desk
from demo_station_pictures import Pictures
from demo_station_settings import write_settings
from demo_station_story import OPERATOR
from demo_station_truth import RIGHT, SENSORS, Truth
from demo_station_worker import HostClock

from station.api import build_app
from station.client import StationClient
from station.serve.web import server_config
from station.settings import load_settings

PATIENCE_S = 90.0
LIVE_SESSION, LIVE_PICTURES = "right-today", 7


@dataclass
class Demo:
    """A demo station that is served."""

    url: str
    keys: dict[str, str]
    """The text of a key of each scope."""
    data: DemoData
    folder: Path
    """Of its own data; nothing done here reaches anybody else's."""
    cameras: DemoCameras | None = None
    """None where the API is served alone."""

    @contextmanager
    def client(self, scope: str = "admin") -> Generator[StationClient]:
        """Open a connection to its API."""
        with StationClient.connect(self.url, self.keys[scope]) as client:
            yield client

    def pass_live(self, pass_id: str, *, axles: int = 4, train: str | None = "live") -> None:
        """Have a train go by, recorded and measured; returns when that is done."""
        assert self.cameras is not None, "the API alone has no cameras"
        self.cameras.show("train")
        with self.client("operate") as client:
            client.arm_pass(pass_id, train=train)
            triggers = self.cameras.roll_train_by(axles)
            client.finish_pass(pass_id, triggers=dict.fromkeys(SENSORS, triggers), axles=axles)
            client.await_pass(pass_id, timeout_s=PATIENCE_S)


@contextmanager
def served(data: DemoData, folder: Path, *, port: int = 0) -> Generator[Demo]:
    """Run `station serve` on a copy of the data, before simulated cameras."""
    data.copy_to(folder)
    cameras = DemoCameras(data.films, folder)
    config = write_settings(
        folder / "station.toml", Truth(SEED), addresses=cameras.addresses, port=port
    )
    log = folder / "station.log"
    try:
        cameras.start()
        with log.open("w") as stderr:
            process = subprocess.Popen(
                [sys.executable, "-m", "station", "serve", "--config", config, "--json"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                env=_environment(folder),
            )
        try:
            yield Demo(_url_once_ready(process, log), dict(data.told.keys), data, folder, cameras)
        finally:
            _end(process)
    finally:
        cameras.stop()


def _environment(folder: Path) -> dict[str, str]:
    inherited = {name: v for name, v in os.environ.items() if not name.startswith("STATION_")}
    # A key of the environment: no key file is left, and no line on stderr.
    return inherited | {"TMPDIR": str(folder), "STATION_ADMIN_KEY": secrets.token_urlsafe(32)}


def _url_once_ready(process: "subprocess.Popen[str]", log: Path) -> str:
    assert process.stdout is not None
    text = ""
    while not text.endswith("}\n"):
        line = process.stdout.readline()
        assert line, f"the demo station did not start:\n{log.read_text(errors='replace')}"
        text += line
    return str(json.loads(text)["url"])


def _end(process: "subprocess.Popen[str]") -> None:
    process.terminate()
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    assert process.stdout is not None
    process.stdout.close()


@contextmanager
def served_quietly(data: DemoData, folder: Path) -> Generator[Demo]:
    """Serve the API alone on a copy of the data; films take the cameras' place.

    A calibration session is open: `LIVE_SESSION`, with `LIVE_PICTURES` pictures.
    """
    data.copy_to(folder)
    settings = load_settings(write_settings(folder / "station.toml", Truth(SEED)))
    desk = Desk(settings, Pictures.of_films(data.films), HostClock())
    _open_session(desk)
    app = build_app(desk.station, admin_key=None, worker_ready=lambda: True)
    listening = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(server_config(app, settings))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
    thread.start()
    url = f"http://127.0.0.1:{listening.getsockname()[1]}"
    try:
        _await(url)
        yield Demo(url, dict(data.told.keys), data, folder)
    finally:
        server.should_exit = True
        thread.join(PATIENCE_S)
        desk.store.close()


def _open_session(desk: Desk) -> None:
    pictures = desk.pictures.targets[RIGHT]
    desk.session(LIVE_SESSION, {RIGHT: pictures[:LIVE_PICTURES]}, by=OPERATOR, finish=False)
    # Whoever presses the button takes more.
    desk.films[RIGHT].show(Exposure(0, picture) for picture in islice(cycle(pictures), 500))


def _await(url: str) -> None:
    until_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            httpx.get(f"{url}/healthz", trust_env=False, timeout=PATIENCE_S)
        except httpx.TransportError:
            assert time.monotonic() < until_s, "the API does not answer"
            time.sleep(0.05)
        else:
            return
