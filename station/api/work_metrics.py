"""How long measuring takes: seen in the store, as the worker is another process."""

from collections.abc import Iterable
from datetime import datetime

from prometheus_client import Histogram
from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from station.operations import Station
from station.store.watched import measured_since

_PASS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0, 300.0, 600.0, 1800.0)
_WHEEL_S = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


class WorkCollector(Collector):
    """Counts, since this process began, the passes that have come to their end meanwhile."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._seen_until: datetime = station.now()
        self._pass = Histogram(
            "station_pass_results_seconds",
            "From the finish of a pass to the end of its measuring.",
            buckets=_PASS_S,
            registry=None,
        )
        self._wheel = Histogram(
            "station_wheel_measuring_seconds",
            "Measuring of a pass over its wheels: mean of one.",
            buckets=_WHEEL_S,
            registry=None,
        )

    def collect(self) -> Iterable[Metric]:
        with self._station.store.look() as session:
            ended = measured_since(session, self._seen_until)
        for each in ended:
            self._seen_until = each.ended_at
            self._pass.observe(max((each.ended_at - each.finished_at).total_seconds(), 0.0))
            if each.wheels:
                took_s = (each.ended_at - each.started_at).total_seconds()
                self._wheel.observe(took_s / each.wheels)
        return [*self._pass.collect(), *self._wheel.collect()]
