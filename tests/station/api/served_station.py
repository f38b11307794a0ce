"""The real API, on a real store and socket; camera and worker are doubles of their clients."""

import asyncio
import os
import shutil
import socket
import threading
from dataclasses import dataclass, field
from pathlib import Path

import httpx
import uvicorn

from station.api import build_app
from station.capture import CaptureReport, CaptureState, CaptureStatus, Look
from station.errors import CameraUnreachable, StateConflict
from station.operations import DataLayout, Salvaged, Station, utc_now
from station.serve.web import server_config
from station.settings import StationSettings
from station.store import Store
from station.store.callers import Scope, add_key

PATIENCE_S = 60.0
ADMIN_KEY = "a-key-for-automation-of-32-or-more-letters"


@dataclass
class FakeCapture:
    """A sensor whose camera sees `wheels` wheels in every pass."""

    wheels: int = 4
    lost: int = 0
    plan: object = None
    plans: list = field(default_factory=list)
    pictures: int = 0
    broken: str | None = None
    broken_trigger: bool = False
    gate: threading.Event | None = None
    age_s: float | None = None
    """Time since it was armed, where the test says it; and since the last frame."""
    silent_s: float | None = None

    def status(self):
        self._ensure_works()
        return CaptureStatus(
            CaptureState.RECORDING if self.plan else CaptureState.IDLE,
            "left",
            session_id=self.plan.session_id if self.plan else None,
            path=self.plan.path if self.plan else None,
            recording_s=self.age_s if self.plan else None,
            silent_s=self.silent_s if self.plan else None,
            recorded=self.pictures,
            totals={"recorded": self.pictures, "lost": self.lost},
        )

    def arm(self, plan):
        self._ensure_works()
        if self.plan is not None:
            raise StateConflict("a recording runs already", state="recording")
        self.plan, self.pictures = plan, 0
        self.plans.append(plan)

    def trigger(self):
        self._ensure_works()
        if self.broken_trigger:
            raise CameraUnreachable("no frame came")
        self.pictures += 1
        return self.pictures

    def look(self):
        self._ensure_works()
        if self.plan is not None:
            raise StateConflict("the sensor is recording", state="recording")
        descriptor = os.memfd_create("look")
        os.write(descriptor, bytes(64 * 48))
        return Look(descriptor, 64, 48, 1_782_907_200_000_000_000)

    def finish(self, expected_frames=None):
        if self.gate is not None:
            self.gate.wait(PATIENCE_S)
        self._ensure_works()
        if self.plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        plan, self.plan = self.plan, None
        recorded = self.pictures or self.wheels - self.lost
        missing = self.lost if expected_frames is None else max(expected_frames - recorded, 0)
        return CaptureReport(
            path=plan.path,
            triggered=expected_frames,
            recorded=recorded,
            lost=missing,
            refused=0,
            repeated=0,
            resent_packets=0,
            first_time_ns=None,
            last_time_ns=None,
            events=(),
        )

    def _ensure_works(self):
        if self.broken is not None:
            raise CameraUnreachable(self.broken)


@dataclass
class FakeQueue:
    submitted: list = field(default_factory=list)
    cancelled: list = field(default_factory=list)

    def submit(self, kind, job_id):
        self.submitted.append((kind.value, job_id))

    def cancel(self, job_id):
        self.cancelled.append(job_id)


SENSORS = (
    {"id": "left", "address": "127.0.0.2"},
    {"id": "right", "address": "127.0.0.3", "side": "right"},
)


class _HastyAsyncio:
    """What uvicorn knows as asyncio, with shorter sleeps.

    It looks every tenth of a second whether it is to end, and waits as long for the ones who are
    connected: a minute of waiting over all tests.
    """

    def __getattr__(self, name):
        return getattr(asyncio, name)

    @staticmethod
    async def sleep(delay_s):
        await asyncio.sleep(min(delay_s, 0.005))


def end_servers_at_once(monkeypatch):
    """Have every server of this process end as soon as it is told to."""
    monkeypatch.setattr(uvicorn.server, "asyncio", _HastyAsyncio())


class Served:
    """A station whose API is served, and what is needed to play with it."""

    def __init__(
        self, root: Path, empty_store: Path | None, *, sensors=SENSORS, **settings
    ) -> None:
        self.settings = StationSettings(data_dir=root, sensors=sensors, **settings)
        self.layout = DataLayout.of(self.settings)
        if self.settings.store_url is None:
            shutil.copy(empty_store, root / "station.sqlite")
        self.store = Store.open(self.layout.store_url)
        self.captures = {sensor.id: self._capture(sensor) for sensor in self.settings.sensors}
        self.queue = FakeQueue()
        self.saved: dict[str, int] = {}
        self.worker_ready = True
        self.station = Station(
            settings=self.settings,
            store=self.store,
            layout=self.layout,
            captures=self.captures,
            jobs=self.queue,
            salvage=self._salvage,
        )
        self.begin()

    def begin(self) -> None:
        """Begin to serve, as a new API process does."""
        app = build_app(
            self._station_of_process(),
            admin_key=ADMIN_KEY,
            worker_ready=lambda: self.worker_ready,
        )
        self.app = app
        listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{listening.getsockname()[1]}"
        self.server = uvicorn.Server(server_config(app, self.settings))
        self._thread = threading.Thread(
            target=self.server.run, kwargs={"sockets": [listening]}, daemon=True
        )
        self._thread.start()

    def end(self) -> None:
        """Serve no more; the store and the doubles stay."""
        self.server.should_exit = True
        self._thread.join(PATIENCE_S)

    def _capture(self, _sensor):
        return FakeCapture()

    def _station_of_process(self) -> Station:
        return self.station

    def _salvage(self, path):
        frames = self.saved.get(path.stem)
        return None if frames is None else Salvaged(frames, f"{frames} frames saved")

    def client(self, key: str | None = ADMIN_KEY) -> httpx.Client:
        headers = {} if key is None else {"Authorization": f"Bearer {key}"}
        return httpx.Client(base_url=self.url, headers=headers, timeout=PATIENCE_S, trust_env=False)

    def key(self, *scopes: Scope) -> str:
        with self.store.change() as session:
            return add_key(session, "test", scopes, at=utc_now())

    def close(self) -> None:
        self.end()
        self.store.close()
