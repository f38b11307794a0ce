"""The cameras of the demo station: they show a train, or a target, as they are told."""

import os
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from demo_station_truth import HEIGHT_PX, SENSORS, WIDTH_PX

from calib import Picture
from station.simulated import SimulatedCameraProcess

_NEXT_AXLE_S = 0.4
Shown = Literal["train", "target"]


class TwoFilms:
    """Serves one of two films, from its beginning each time it is put on."""

    width, height = WIDTH_PX, HEIGHT_PX

    def __init__(self, folder: Path, sensor: str, put_on: Path) -> None:
        self._films = {
            name: np.load(folder / f"{name}-{sensor}.npy", mmap_mode="r")
            for name in ("train", "target")
        }
        self._put_on = put_on
        self._present, self._began = "", 0

    def frame(self, index: int, exposure_us: float) -> Picture:
        told = self._put_on.read_text()
        if told != self._present:
            self._present, self._began = told, index
        film = self._films[told.split()[0]]
        return np.asarray(film[(index - self._began) % len(film)])


@dataclass(frozen=True)
class Shows:
    """Makes the films of a camera, in the process that serves it."""

    folder: Path
    sensor: str
    put_on: Path

    def __call__(self) -> TwoFilms:
        return TwoFilms(self.folder, self.sensor, self.put_on)


class DemoCameras:
    """All cameras of the demo station, each in a process of its own.

    Parameters
    ----------
    films
        The folder with what they show.
    folder
        Takes the note that says which film is on.
    """

    def __init__(self, films: Path, folder: Path) -> None:
        # Stations of several processes of this host must not meet the same cameras.
        network = f"127.41.{os.getpid() % 250 + 2}"
        self._put_on, self._turns = folder / "put-on", 0
        self.addresses = {name: f"{network}.{place}" for place, name in enumerate(SENSORS, start=1)}
        self.show("train")
        self.by_sensor: Mapping[str, SimulatedCameraProcess] = {
            name: SimulatedCameraProcess(
                address, Shows(films, name, self._put_on), serial=f"DEMO-{name}"
            )
            for name, address in self.addresses.items()
        }

    def start(self) -> None:
        """Start them all."""
        with ThreadPoolExecutor(len(self.by_sensor)) as pool:
            list(pool.map(SimulatedCameraProcess.start, self.by_sensor.values()))

    def stop(self) -> None:
        """Stop them; safe to call twice."""
        for camera in self.by_sensor.values():
            camera.stop()

    def show(self, film: Shown) -> None:
        """Put a film on, from its beginning."""
        self._turns += 1
        following = self._put_on.with_suffix(".next")
        following.write_text(f"{film} {self._turns}")
        following.replace(self._put_on)

    def roll_train_by(self, axles: int) -> None:
        """Trigger all cameras by their Line1 as axles come by, once each."""
        started_s = time.monotonic()
        for axle in range(axles):
            time.sleep(max(0.0, started_s + axle * _NEXT_AXLE_S - time.monotonic()))
            now_ns = time.time_ns()
            for camera in self.by_sensor.values():
                camera.trigger_line1(now_ns)
