"""What the station counts, for Prometheus."""

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)

from station.api.capture_metrics import CaptureCollector
from station.api.fleet_metrics import FleetCollector
from station.api.host_metrics import HostCollector
from station.api.patient_collector import PatientCollector
from station.api.recalibration_metrics import RecalibrationCollector
from station.api.store_metrics import StoreCollector
from station.api.watching_metrics import WatchingCollector
from station.api.work_metrics import WorkCollector
from station.operations import Station
from station.watching import Lookout

_SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0, 20.0)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS"})


class Metrics:
    """The station's metrics, in a registry of their own."""

    def __init__(self, station: Station, lookout: Lookout) -> None:
        # Three more lines for each route, which nobody asks for.
        disable_created_metrics()  # type: ignore[no-untyped-call]  # the library has no types here
        self._registry = CollectorRegistry()
        parts = {
            "watching": WatchingCollector(lookout, station.settings.name),
            "capture": CaptureCollector(lookout, station.captures),
            "store": StoreCollector(station),
            "work": WorkCollector(station),
            "calibrations": RecalibrationCollector(station),
            "host": HostCollector(station),
            "fleet": FleetCollector(station),
        }
        self._registry.register(PatientCollector(parts))
        ProcessCollector(registry=self._registry)
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
        # A caller may invent methods too, and each would be kept for ever.
        method = method if method in _METHODS else "other"
        self._answered.labels(method, route, str(status)).inc()
        self._seconds.labels(method, route).observe(seconds)

    def text(self) -> bytes:
        """Return everything in Prometheus' text format."""
        return generate_latest(self._registry)
