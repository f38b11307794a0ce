"""The figures of the README, measured where they are asked for."""

from collections.abc import Callable

from station.bench.capture import bench_capture
from station.bench.deviations import bench_deviations
from station.bench.lights import bench_lights
from station.bench.paper import bench_paper
from station.progress import Progress
from station.tables import Table

BENCHES: dict[str, Callable[[Progress], Table]] = {
    "capture": bench_capture,
    "lights": bench_lights,
    "paper": bench_paper,
    "deviations": bench_deviations,
}

__all__ = ["BENCHES", "bench_capture", "bench_deviations", "bench_lights", "bench_paper"]
