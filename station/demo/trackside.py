"""The simulated trackside: cameras that look at the scenario, and the station behind them."""

import os
import secrets
import subprocess
import sys
import time
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from station.client import StationClient
from station.demo.rendering import RenderedFrames, frames_path
from station.demo.scenario import AXLES, OFFSETS_MM, REFERENCE, SHOWINGS, Scenario, SensorTruth
from station.errors import StationError
from station.processes.port import port_for_later
from station.simulated import SimulatedCameraProcess

_START_PATIENCE_S = 120.0
_STOP_PATIENCE_S = 60.0
_FRAME_INTERVAL_S = 1.0 / 53.0
_WHEEL_INTERVAL_S = 0.5
"""A train at 18 km/h with axles 2.5 m apart."""


@contextmanager
def cameras_of(scenario: Scenario, folder: Path) -> Generator[dict[str, SimulatedCameraProcess]]:
    """Run one simulated camera a sensor, each in a process of its own."""
    with ExitStack() as stack:
        cameras = {
            truth.id: SimulatedCameraProcess(
                truth.address, RenderedFrames(frames_path(folder, truth.id)), serial=truth.id
            )
            for truth in scenario.sensors
        }
        for camera in cameras.values():
            stack.callback(camera.stop)
        with ThreadPoolExecutor(len(cameras)) as pool:
            list(pool.map(SimulatedCameraProcess.start, cameras.values()))
        yield cameras


@dataclass(frozen=True, slots=True)
class RunningStation:
    """The station's process, and what is needed to call it."""

    process: subprocess.Popen[bytes]
    url: str
    key: str
    data_dir: Path

    def stop(self) -> None:
        """End the station; safe to call twice."""
        self.process.terminate()
        try:
            self.process.wait(_STOP_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


@contextmanager
def station_of(scenario: Scenario, folder: Path) -> Generator[RunningStation]:
    """Run `station serve` for the sensors of the scenario; its log goes to ``station.log``."""
    port = port_for_later()
    config = folder / "station.toml"
    config.write_text(settings_toml(scenario, folder, port), encoding="utf-8")
    key = secrets.token_urlsafe(32)
    log = (folder / "station.log").open("wb")
    with log:
        process = subprocess.Popen(  # noqa: S603  our own interpreter and module
            [sys.executable, "-m", "station", "serve", "--config", str(config)],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env={**os.environ, "STATION_ADMIN_KEY": key},
        )
        station = RunningStation(process, f"http://127.0.0.1:{port}", key, folder)
        try:
            yield station
        finally:
            station.stop()


def await_ready(station: RunningStation, client: StationClient) -> None:
    """Wait until every part of the station is ready.

    Raises
    ------
    StationError
        If the station ends, or is not ready within two minutes.
    """
    deadline = time.monotonic() + _START_PATIENCE_S
    while not client.ready():
        if station.process.poll() is not None or time.monotonic() > deadline:
            log = (station.data_dir / "station.log").read_text(errors="replace").splitlines()
            raise StationError(
                f"the station did not get ready; its last word: {log[-1] if log else 'none'}"
            )
        time.sleep(0.1)


def roll_train_by(cameras: dict[str, SimulatedCameraProcess]) -> dict[str, int]:
    """Trigger every camera by its Line1 as the axles come by; return how often each was."""
    counts = dict.fromkeys(cameras, 0)
    start_s = time.monotonic()
    for axle in range(AXLES):
        for frame in range(len(OFFSETS_MM)):
            due_s = start_s + axle * _WHEEL_INTERVAL_S + frame * _FRAME_INTERVAL_S
            time.sleep(max(0.0, due_s - time.monotonic()))
            now_ns = time.time_ns()
            for sensor, camera in cameras.items():
                counts[sensor] += camera.trigger_line1(now_ns)
    return counts


def settings_toml(scenario: Scenario, folder: Path, port: int) -> str:
    """Return station.toml for the sensors and rigs of the scenario."""
    lines = [
        'name = "demo"',
        f'data_dir = "{folder}"',
        f"port = {port}",
        f'reference = "{REFERENCE}"',
        "[storage]",  # space for what the demo records, not for the longest train
        "keep_free_gb = 0.1",
        f"most_poses = {SHOWINGS}",
        f"most_axles = {AXLES * len(OFFSETS_MM)}",
    ]
    for rig in scenario.rigs:
        for truth in rig.sensors:
            lines += [
                "",
                "[[sensors]]",
                f'id = "{truth.id}"',
                f'side = "{rig.side}"',
                f'address = "{truth.address}"',
                'trigger = "Line1"',
            ]
            if truth is rig.anchor:
                lines += _mounting_toml(truth)
    for rig in scenario.rigs:
        names = ", ".join(f'"{truth.id}"' for truth in rig.sensors)
        lines += ["", "[[rigs]]", f'id = "{rig.id}"', f"sensors = [{names}]"]
    return "\n".join([*lines, ""])


def _mounting_toml(truth: SensorTruth) -> list[str]:
    return [
        "[sensors.mounting]",
        f"rotation_vector = {truth.rig_from_camera.rotation_vector.tolist()}",
        f"translation_mm = {truth.rig_from_camera.translation_mm.tolist()}",
    ]
