"""The demo station served: by all its processes before simulated cameras, or by its API alone."""

import json
import os
import secrets
import subprocess
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
from demo_station_cameras import DemoCameras
from demo_station_data import SEED, DemoData
from demo_station_settings import write_settings
from demo_station_truth import BOARDS, RIGHT, SENSORS, Truth

from station.client import StationClient

PATIENCE_S = 90.0


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

    def ask(self, path: str, scope: str = "read") -> httpx.Response:
        """Return the answer to a GET."""
        headers = {"Authorization": f"Bearer {self.keys[scope]}"}
        return httpx.get(
            f"{self.url}{path}", headers=headers, timeout=PATIENCE_S, trust_env=False
        ).raise_for_status()

    def pass_live(self, pass_id: str, *, axles: int = 4, train: str | None = "live") -> None:
        """Have a train go by, recorded and measured; returns when that is done."""
        assert self.cameras is not None, "the API alone has no cameras"
        with self.client("operate") as client:
            client.arm_pass(pass_id, train=train)
            self.cameras.show("train")  # once nobody can look through them any more
            self.cameras.roll_train_by(axles)
            client.finish_pass(pass_id, triggers=dict.fromkeys(SENSORS, axles), axles=axles)
            client.await_pass(pass_id, timeout_s=PATIENCE_S)

    def show_target(self, session: str, *, pictures: int = 6) -> None:
        """Open a calibration session of the right sensor, and take pictures of its target."""
        assert self.cameras is not None, "the API alone has no cameras"
        with self.client("calibrate") as client:
            client.open_calibration_session(session, sensor=RIGHT, target=str(BOARDS[RIGHT]))
            self.cameras.show("target")
            for _ in range(pictures):
                client.capture(session)


@contextmanager
def served(data: DemoData, folder: Path, *, port: int = 0) -> Generator[Demo]:
    """Run `station serve` on a copy of the data, before simulated cameras."""
    data.copy_to(folder)
    cameras = DemoCameras(data.films, folder)
    config = write_settings(
        folder / "station.toml", Truth(SEED), addresses=cameras.addresses, port=port
    )
    try:
        cameras.start()
        with _running(["-m", "station", "serve", "--config", config, "--json"], folder) as url:
            yield Demo(url, dict(data.told.keys), data, folder, cameras)
    finally:
        cameras.stop()


@contextmanager
def served_quietly(data: DemoData, folder: Path, *, port: int = 0) -> Generator[Demo]:
    """Serve API and pages alone on a copy of the data, with films in place of cameras.

    A calibration session is open: `LIVE_SESSION`, with `LIVE_PICTURES` pictures.
    """
    data.copy_to(folder)
    write_settings(folder / "station.toml", Truth(SEED), port=port)
    program = Path(__file__).with_name("demo_station_quiet.py")
    with _running([program, folder, data.films], folder) as url:
        yield Demo(url, dict(data.told.keys), data, folder)


@contextmanager
def _running(command: Sequence[str | Path], folder: Path) -> Generator[str]:
    """Run a command of this Python; yield the URL that it says once it is ready."""
    log = folder / "station.log"
    with log.open("w") as stderr:
        process = subprocess.Popen(
            [sys.executable, *command],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            env=_environment(folder),
        )
    try:
        yield _url_once_ready(process, log)
    finally:
        _end(process)


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
