"""Rendering all that the cameras will see, on all cores, before the first exposure.

A wheel passes in 20 ms; no renderer keeps up with that, so the pictures wait in a file.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from calib import Picture
from station.demo.scenario import Scenario
from station.processes.pool import pool_of_processes
from station.simulated import ArraySource


@dataclass(frozen=True, slots=True)
class RenderedFrames:
    """Makes the frame source of a simulated camera, in the process that serves it."""

    path: Path

    def __call__(self) -> ArraySource:
        return ArraySource(list(np.load(self.path, mmap_mode="r")))


def render_scenario(scenario: Scenario, folder: Path) -> Iterator[tuple[int, int]]:
    """Render every scene to ``frames_path(folder, sensor id)``; yield how many of how many."""
    tasks = [
        (scenario.seed, place, index)
        for place, sensor in enumerate(scenario.sensors)
        for index in range(len(sensor.scenes))
    ]
    stores = [
        np.lib.format.open_memmap(
            frames_path(folder, truth.id),
            mode="w+",
            dtype=np.uint8,
            shape=(len(truth.scenes), truth.sensor.camera.height, truth.sensor.camera.width),
        )
        for truth in scenario.sensors
    ]
    with pool_of_processes(len(os.sched_getaffinity(0))) as pool:
        pictures = pool.map(_render, tasks)
        for done, ((_, place, index), picture) in enumerate(
            zip(tasks, pictures, strict=True), start=1
        ):
            stores[place][index] = picture
            yield done, len(tasks)
    for store in stores:
        store.flush()


def frames_path(folder: Path, sensor_id: str) -> Path:
    """Where the rendered frames of a sensor lie."""
    return folder / f"frames-{sensor_id}.npy"


def _render(task: tuple[int, int, int]) -> Picture:
    seed, place, index = task
    return _scenario(seed).sensors[place].render(index)


@lru_cache(maxsize=1)
def _scenario(seed: int) -> Scenario:
    """Draw the scenario once a process: a seed is cheaper to send than its scenes."""
    return Scenario.draw(seed)
