"""What the station counts, for Prometheus."""

import shutil
from collections.abc import Iterable

from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from station.api.capture_metrics import CaptureCollector
from station.api.recalibration_metrics import RecalibrationCollector
from station.operations import Station
from station.store import Job, Pass, counts_by_state, frame_totals

_SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0, 20.0)


class _StoreCollector(Collector):
    """Reads counts from the store when they are asked for."""

    def __init__(self, station: Station) -> None:
        self._station = station

    def collect(self) -> Iterable[Metric]:
        with self._station.store.look() as session:
            passes = counts_by_state(session, Pass)
            jobs = counts_by_state(session, Job)
            frames = frame_totals(session)
        yield _by_label("station_passes", "Passes by state.", "state", passes)
        yield _by_label("station_jobs", "Jobs by state.", "state", jobs)
        yield _frames(frames)
        free = shutil.disk_usage(self._station.layout.root).free
        yield GaugeMetricFamily("station_disk_free_bytes", "Space left for data.", value=free)


def _frames(counts: dict[tuple[str, str], int]) -> GaugeMetricFamily:
    family = GaugeMetricFamily(
        "station_frames", "Frames of all recordings by fate.", labels=["sensor", "fate"]
    )
    for labels, count in counts.items():
        family.add_metric(labels, count)
    return family


def _by_label(name: str, text: str, label: str, values: dict[str, int]) -> GaugeMetricFamily:
    family = GaugeMetricFamily(name, text, labels=[label])
    for value, count in values.items():
        family.add_metric([value], count)
    return family


class Metrics:
    """The station's metrics, in a registry of their own."""

    def __init__(self, station: Station) -> None:
        self._registry = CollectorRegistry()
        self._registry.register(_StoreCollector(station))
        self._registry.register(CaptureCollector(station))
        self._registry.register(RecalibrationCollector(station))
        self._answered = Counter(
            "station_http_requests",
            "Requests answered.",
            ["method", "route", "status"],
            registry=self._registry,
        )
        self._seconds = Histogram(
            "station_http_seconds",
            "Time to the answer, s.",
            ["method", "route"],
            buckets=_SECONDS,
            registry=self._registry,
        )

    def count(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count an answered request; `route` is the template, never the address itself."""
        self._answered.labels(method, route, str(status)).inc()
        self._seconds.labels(method, route).observe(seconds)

    def text(self) -> bytes:
        """Return everything in Prometheus' text format."""
        return generate_latest(self._registry)
